// The self-test: the server predicts it, which moves nothing, and then the device makes the moves.
// A move starts only while this page sends keep-alives.

import { app, by, element, may, on } from './app';
import { reason } from './commissioning';
import { count } from './count';
import { fill, number, numberOrNothing } from './field';
import { doubted, last, offer } from './identified';
import type { Event, Link } from './link';
import { turnOn } from './motions';
import { shown } from './plots';
import { ask, reportGraded, MARKS, report, type Grade } from './messages';
import { download, stamp } from './session';
import { brief, table } from './tuning';

type Range = { least: number | null; median: number | null; largest: number | null };
type Check = {
  name: string;
  words?: string;
  measured?: number | null;
  predicted: Range;
  least: number | null;
  most: number;
  pass?: boolean;
};
type Move = {
  to_deg: number;
  settled_s: number | null;
  rest_counts: number;
  reversals: number;
  sticks_in_motion: number;
  held_v: number;
  sliding_v: number | null;
  predicted_settled_s: Range | null;
  predicted_rest_counts: Range | null;
};

const LOOKS: Record<Grade, string> = { good: 'passed', doubtful: 'doubted', bad: 'failed' };

// The verdict with its doubts, which always appear together.
const doubts = ({ said: verdict, result, unseen_slack: slack }: Event): string =>
  [
    verdict,
    ...(slack ? [`Note: ${slack}.`] : []),
    ...(result?.doubts ?? []).map((one: string) => `Doubtful: ${one}`),
  ].join('\n');

// Fields of the request; a change needs another prediction.
const FIELDS = ['selftest-joint', 'selftest-moves', 'selftest-range'];

export class Selftest {
  private phase = 'none';
  private why: string | null = null;
  private ofFound = false;
  private file: string | null = null;
  // Whether the last prediction is that of the fields.
  private fits = false;
  // Number of that prediction.
  private predicted: number | null = null;

  constructor(private readonly link: Link) {
    on('selftest-predict', () => void this.predict());
    on('selftest-cancel', () => void this.cancel());
    for (const id of FIELDS) by(id).oninput = () => this.changed();
    on('selftest-go', () => {
      // The number at the click: another prediction may come before the word is typed.
      const number = this.predicted;
      turnOn(
        'The self-test moves the joint automatically, for minutes',
        () => void ask(this.link, 'selftest', { number }),
      );
    });
  }

  // The end of the prediction is reported by its event.
  private async cancel(): Promise<void> {
    const answer = await this.link.ask('cancel-selftest');
    if (!answer.ok) report(answer.said, false);
  }

  // Sets the fields to a new prediction, which another page may have requested. A repeated event of
  // the same prediction does not change fields that were edited since.
  private setFields({ number, deg, joint, moves }: Event): void {
    if (number === undefined || number === this.predicted) return;
    this.predicted = number;
    fill('selftest-moves', String(moves));
    fill('selftest-range', deg === null ? '' : String(deg));
    const select = by<HTMLSelectElement>('selftest-joint');
    select.value = joint;
    // The list may not have that joint.
    this.fits = select.value === joint;
  }

  // An edited field disables the moves of the older prediction.
  private changed(): void {
    this.fits = false;
    this.enable();
  }

  private async predict(): Promise<void> {
    this.changed();
    const joint = by<HTMLSelectElement>('selftest-joint').value || 'file';
    const moves = number('selftest-moves');
    const deg = numberOrNothing('selftest-range');
    if (moves === null || deg === null) return;
    if (!Number.isInteger(moves) || moves < 2 || moves > 200)
      return report(`${count(moves, 'move')}: it must be a whole number from 2 to 200`, false);
    const answer = await ask(this.link, 'predict-selftest', { moves, deg, joint });
    if (!answer.ok) this.say(`✕ ${answer.said}`);
  }

  // A screen reader speaks it when it changes, not with each joint.
  private say(text: string): void {
    if (by('selftest-said').textContent !== text) by('selftest-said').textContent = text;
  }

  // Updates the list of joints.
  whose(): void {
    if (offer('selftest-joint', this.file && last(this.file), this.ofFound)) this.changed();
    this.enable();
  }

  update(event: Event): void {
    const before = this.phase;
    this.phase = event.phase;
    [this.why, this.ofFound, this.file] = [event.why, event.of_found, event.file ?? null];
    app.testing = event.phase === 'moving';
    this.whose();
    this.setFields(event);
    const range = event.range_deg ?? event.result?.range_deg;
    if (range !== undefined)
      by('selftest-go').textContent =
        `2. Make the ${count(event.moves, 'move')} within ${shown(range)} deg, compared with ` +
        `the joint of ${last(event.machine)}`;
    const bar = by<HTMLProgressElement>('selftest-runs');
    if (event.phase === 'moving') [bar.max, bar.value] = [event.moves, event.made];
    else if (event.phase === 'predicting') [bar.max, bar.value] = [event.joints, event.over];
    this.say(this.words(event));
    const grade = this.grade(event);
    by('selftest-said').className = event.phase === 'done' ? LOOKS[grade] : '';
    if (event.phase === 'ready') this.ready(event);
    if (event.phase === 'done') {
      this.done(event);
      if (before === 'moving') reportGraded(`self-test: ${doubts(event)}`, grade);
    }
    const isOver = before === 'predicting' || before === 'moving';
    if (event.phase === 'none' && event.said && isOver) report(event.said, false, '✕');
    if (event.phase === 'none' || event.phase === 'predicting')
      by('selftest-result').replaceChildren();
    this.enable();
  }

  // A pass with a doubt is only doubtful.
  private grade({ ok, result }: Event): Grade {
    if (!ok) return 'bad';
    return result?.remark || result?.doubts?.length ? 'doubtful' : 'good';
  }

  private words(event: Event): string {
    switch (event.phase) {
      case 'predicting':
        return (
          `Predicting ${count(event.moves, 'move')} of ${event.joints} simulated joints around that of ` +
          `${last(event.machine)}. Nothing moves.`
        );
      case 'ready':
        return (
          `${count(event.moves, 'move')}, within ${shown(event.range_deg)} deg to either side of the ` +
          `present position, in up to ${duration(event.longest_s)}. Keep that room clear.` +
          (event.predicted_sides ? `\n${event.predicted_sides}` : '') +
          (event.unseen_slack ? `\nNote: ${event.unseen_slack}.` : '')
        );
      case 'moving':
        return event.to_deg === null
          ? 'Armed: the first move starts after the soft start.'
          : `Move ${event.made + 1} of ${event.moves}, to ${shown(event.to_deg)} deg.`;
      case 'done':
        return `${MARKS[this.grade(event)]} ${doubts(event)}`;
      default:
        return event.said ? `✕ ${event.said}` : '';
    }
  }

  enable(): void {
    const { phase, why } = this;
    const isKnown = by<HTMLSelectElement>('selftest-joint').value !== '';
    const off = may() && app.status?.state === 'stopped' && isKnown;
    const set = (id: string, enabled: boolean) => {
      by<HTMLButtonElement>(id).disabled = !enabled;
    };
    const busy = phase === 'predicting' || phase === 'moving';
    for (const id of ['selftest-predict', ...FIELDS]) set(id, off && !busy);
    const isPredicted = phase === 'ready' || phase === 'done';
    set('selftest-go', off && isPredicted && this.fits);
    set('selftest-cancel', may() && phase === 'predicting');
    by('selftest-cancel').hidden = phase !== 'predicting';
    by('selftest-runs').hidden = !busy;
    let text = '';
    if (!isKnown && why !== null) text = `✕ ${why}`;
    else if (!off && phase !== 'moving') text = `Not now: ${reason('')}.`;
    else if (isPredicted && !this.fits) text = 'Predict with these fields before the moves.';
    if (by('selftest-why').textContent !== text) by('selftest-why').textContent = text;
  }

  private ready({ checks, joints, spreads, doubts, differences, machine }: Event): void {
    by('selftest-result').replaceChildren(
      element('p', {
        className: 'hint',
        textContent:
          `Predictions of ${joints} simulated joints around that of ${last(machine)}, with ` +
          `${spreads.map(brief).join(', ')}:`,
      }),
      table(
        ['all moves', 'predicted', 'allowed'],
        checks.map((one: Check) => [one.words ?? one.name, range(one.predicted), allowed(one)]),
      ),
      ...doubted(doubts),
      ...differing(differences),
    );
  }

  private done({ result, labels }: Event): void {
    const save = element('button', { id: 'selftest-save', textContent: 'Download as JSON' });
    save.onclick = () =>
      download(
        new Blob([`${JSON.stringify(result, null, 2)}\n`], { type: 'application/json' }),
        `selftest-${stamp()}.json`,
      );
    const checks: Check[] = result.checks;
    const moves: Move[] = result.moves;
    const each = element('details');
    each.append(
      element('summary', { textContent: `Each of the ${count(moves.length, 'move')}` }),
      table(
        [
          'to, deg',
          'settled, s',
          'predicted',
          'rest, counts',
          'predicted',
          'reversals',
          'stops',
          'sliding, V',
          'held, V',
        ],
        moves.map((one) => [
          one.to_deg.toFixed(3),
          one.settled_s === null ? 'never' : one.settled_s.toFixed(2),
          range(one.predicted_settled_s),
          shown(one.rest_counts),
          range(one.predicted_rest_counts),
          String(one.reversals),
          String(one.sticks_in_motion),
          one.sliding_v === null ? '–' : one.sliding_v.toFixed(3),
          one.held_v.toFixed(3),
        ]),
      ),
    );
    const figures = table(
      ['', 'all moves', 'measured', 'predicted', 'allowed'],
      checks.map((one) => [
        one.pass ? '✓ pass' : '✕ FAIL',
        labels[one.name] ?? one.name,
        one.measured === null || one.measured === undefined ? '–' : shown(one.measured),
        range(one.predicted),
        allowed(one),
      ]),
    );
    by('selftest-result').replaceChildren(
      ...(result.warning ? [element('p', { className: 'hint', textContent: result.warning })] : []),
      ...(checks.length ? [figures] : []),
      ...differing(result.differences),
      ...(moves.length ? [each] : []),
      element('div', { className: 'tools' }, save),
    );
  }
}

// Formats a range. A missing end means never: a fault has no time.
function range(of: Range | null): string {
  if (!of) return '–';
  const [low, high] = [of.least, of.largest].map((one) => (one === null ? 'never' : shown(one)));
  return low === high ? low : `${low} to ${high}`;
}

function allowed({ name, least, most }: Check): string {
  // Counts are whole numbers.
  const end = /_(v|s)$/.test(name) ? shown(most) : String(Math.floor(most));
  return least === null ? `up to ${end}` : `${shown(least)} to ${end}`;
}

function differing(lines: string[]): HTMLElement[] {
  if (lines.length === 0) return [];
  const list = element('details');
  list.append(
    element('summary', {
      textContent:
        `The device differs from the file in ${count(lines.length, 'value')}; the prediction uses ` +
        'the device’s',
    }),
    element('ul', {}, ...lines.map((line) => element('li', { textContent: line }))),
  );
  return [list];
}

function duration(seconds: number): string {
  return seconds < 100 ? `${Math.ceil(seconds)} s` : `${Math.ceil(seconds / 60)} minutes`;
}
