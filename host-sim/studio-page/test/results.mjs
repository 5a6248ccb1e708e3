// Tests of how a result is marked: by its grade, with its doubts, and without a button where there
// is nothing to take. The server's results are replaced by some that no joint of the tests has.

import assert from 'node:assert/strict';

const DOUBT = 'the friction differs from place to place';

// The encoder's side succeeds on all joints, the load's side on this number.
const figures = (successes) => ({
  cases: 48,
  successes_at_encoder: 48,
  successes_at_load: successes,
  settled_at_encoder_s: 1,
  settled_at_load_s: 5,
  tracking_at_encoder_counts: null,
  tracking_at_load_counts: null,
  rest_at_encoder_counts: 1,
  rest_at_load_counts: 80,
  chatter_v_per_s: 1,
  held_v: 0.1,
});

const REASON = 'no gains can rest the load within 2 counts';

const tuned = (successes, doubts) => ({
  event: 'tuned',
  ok: true,
  said: 'better gains were found for 1 of 1 laws',
  goal: 'balanced',
  machine: 'joint.toml',
  joint: 'file',
  joints: 24,
  spreads: [],
  doubts,
  charts: [],
  file: 'joint.tuned.toml',
  unseen_slack: null,
  toml: successes ? '' : null,
  result: {
    controllers: {
      srnf: {
        better: successes > 0,
        outcome: successes ? 'tuned' : 'refused',
        reason: successes ? null : REASON,
        gains: { kp_v_per_deg: { from: 1, to: 2 } },
        before: figures(0),
        after: figures(successes),
        tried: 40,
        gain_margins: [1, 1],
        worst: null,
      },
    },
  },
});

export const results = ({ text, visit }) => ({
  async 'gains that succeed on no joint are not offered, and a doubt is not under a tick'(
    page,
    context,
    address,
  ) {
    const other = await context.newPage();
    let send;
    await other.routeWebSocket(/\/link/, (near) => {
      const far = near.connectToServer();
      far.onMessage((message) => near.send(message));
      send = (event) => near.send(JSON.stringify(event));
    });
    await visit(context, address, other);
    await other.locator('[data-view=commissioning]').click();
    await other.locator('#steps button', { hasText: 'Tune' }).click();
    const buttons = () => other.locator('#tune-result button').count();
    send(tuned(0, []));
    await other.locator('#tune-said', { hasText: REASON }).waitFor();
    assert.match(await text(other, '#tune-said'), /^✕/);
    assert.doesNotMatch(await text(other, '#tuning'), /better gains were found/);
    assert.equal(await buttons(), 0);
    assert.match(await text(other, '#tune-result'), /file, at the encoder[^]*file, at the load/);
    send(tuned(40, [DOUBT]));
    await other.locator('#tune-said', { hasText: DOUBT }).waitFor();
    assert.match(await text(other, '#tune-said'), /^⚠ better gains/);
    assert.equal(await buttons(), 2);
    send(tuned(40, []));
    await other.locator('#tune-said', { hasText: /^✓ better gains/ }).waitFor();
    // An identification: the doubt is in the same entry as its mark, whole and in the window.
    await other.setViewportSize({ width: 800, height: 600 });
    send({ event: 'found', said: `verdict    doubtful\n           ${DOUBT}`, grade: 'doubtful' });
    const entry = other.locator('#said li.doubted', { hasText: DOUBT });
    await entry.waitFor();
    assert.match(await entry.innerText(), /^⚠/);
    const isCut = await other.locator('#said').evaluate((list) => {
      const box = getComputedStyle(list);
      return box.maxHeight !== 'none' || list.scrollHeight > list.clientHeight + 1;
    });
    assert.ok(!isCut, 'the list hides a part of its entries');
    await other.close();
  },
});
