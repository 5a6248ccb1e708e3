// What if: sliders for gains and joint. The server predicts the moves; the page draws them, with
// the last measured move on top.

import { app, by, element, may, on } from './app';
import { Curves, type MoveCurve } from './curves';
import { last, offer } from './identified';
import type { Event, Link } from './link';
import { measured } from './measured';
import { shown } from './plots';
import { LOOKS, type Look } from './terms';
import { parse } from './typed-number';

type Knob = {
  path: string;
  of: string;
  name: string;
  value: number;
  text: string;
  low: number;
  high: number;
  scale: 'ratio' | 'whole';
};
export type Curve = {
  law: string;
  begin_s: number;
  tick_s: number;
  reference_deg?: number[];
  position_deg: number[];
  error_counts: number[];
  effort_v?: number[];
  settled_s: number | null;
  rest_counts: number;
  settled_at_load_s: number | null;
  rest_at_load_counts: number;
  // Only of a joint whose encoder cannot see slack of the gear.
  position_at_load_deg?: number[];
  error_at_load_counts?: number[];
  // Only of a joint with an encoder on its motor and one on its load.
  motor_less_load_deg?: number[];
  fault: string | null;
  refused?: string;
};
type Cloud = {
  law: string;
  settled: number;
  success_at_encoder: number;
  success_at_load: number;
  spreads: string[];
  is_written: boolean;
  refused_joints: string[];
  worst: { place: number; joint: string[] } | null;
  curves: Curve[];
  refused?: string;
};

const STEPS = 1000;
const CLOUD = 24;
const PATIENCE_MS = 4000;
const REDRAWN_MS = 200;
// Relative difference below which a value is unchanged: a slider has four digits.
const SAME = 1e-4;

// Looks of the laws: by colour and dash. The first law is the one with sliders.
const OF_LAWS: Look[] = [
  LOOKS.second,
  LOOKS.third,
  LOOKS.compensation,
  LOOKS.total,
  { ...LOOKS.second, dash: [3, 9] },
  { ...LOOKS.third, dash: [22, 4] },
  { ...LOOKS.compensation, dash: [14, 3, 2, 3, 2, 3, 2, 3] },
];
const OF_CLOUD: Look = { light: '#9fb4c4', dark: '#6b8197', width: 1 };
const OF_MEASURED: Look = { ...LOOKS.primary, width: 3.5 };
// Of the lines without a dash, the measured one is broader, and those of the cloud are finer.
const AT_LOAD: Partial<Look> = { width: 2, dash: [2, 4] };
// Difference below which the two sides of a gear are drawn as one line, counts.
const ONE_LINE = 2;
const OF_WORST: Look = { light: '#b3261e', dark: '#ff7a6e', width: 2 };

const isOfJoint = (knob: Knob) => knob.of === 'joint';

// A motion as the server reads it.
type RequestedMotion = { how: string; deg?: number; trajectory?: object };

// Returns a trajectory at one speed, deg/s, that is long enough for a row of steps to show.
function ramp(speed: number): object {
  const [LEAVES_S, LASTS_S, HALF_BLEND_S] = [0.1, 5, 0.05];
  return {
    corner_times_s: [LEAVES_S, LEAVES_S + LASTS_S],
    corner_positions_deg: [0, LASTS_S * speed],
    half_blend_s: HALF_BLEND_S,
  };
}

export class WhatIf {
  // The last event: the file's joint, and the identified one, if any.
  private of: Event | null = null;
  // The joint of the sliders, and its part of the event.
  private joint = 'file';
  private whoseIs = '';
  private now: Event | null = null;
  private knobs: Knob[] = [];
  private values = new Map<string, number>();
  private laws: string[] = [];
  private chosen = new Set<string>();
  private curves: Curve[] = [];
  private cloud: Cloud | null = null;
  private noCloud = '';
  private asked = 0;
  private number = 0;
  private waits = false;
  private drawn = 0;
  private readonly plots = new Curves(by('what-if-plots'));

  constructor(
    private readonly link: Link,
    private readonly set: (values: Record<string, string>) => Promise<boolean>,
  ) {
    for (const id of ['what-if-way', 'what-if-deg', 'what-if-cloud'])
      by(id).oninput = () => this.ask();
    on('what-if-reset', () => {
      this.values.clear();
      this.build();
      this.ask();
    });
    on('what-if-set', () => void this.set(this.gains()));
    by('what-if-joint').onchange = () => this.whose();
  }

  // Stores new knobs: the parameters have changed, or another joint was identified.
  update(event: Event): void {
    this.of = event;
    this.whose();
  }

  // Updates the list of joints.
  whose(): void {
    const { of } = this;
    if (!of) return;
    offer('what-if-joint', of.why === null ? last(of.machine) : null, of.found !== null);
    this.joint = by<HTMLSelectElement>('what-if-joint').value || 'file';
    const now: Event = this.joint === 'found' ? of.found : of;
    // Sliders of one joint do not apply to another one, which a later identification may find.
    const values = JSON.stringify(now.knobs.filter(isOfJoint).map((knob: Knob) => knob.value));
    const whose = `${this.joint} ${values}`;
    if (whose !== this.whoseIs)
      for (const knob of this.knobs.filter(isOfJoint)) this.values.delete(knob.path);
    this.whoseIs = whose;
    this.take(now);
  }

  private take(event: Event): void {
    this.now = event;
    this.knobs = event.knobs;
    this.laws = event.laws;
    // Sliders stay, except where the value in use is now the same.
    for (const [path, value] of this.values) {
      const knob = this.knobs.find((one) => one.path === path);
      const isOther = knob && Math.abs(value - knob.value) > SAME * Math.abs(knob.value);
      if (!isOther || value < knob.low || value > knob.high) this.values.delete(path);
    }
    for (const law of this.chosen) if (!this.laws.includes(law)) this.chosen.delete(law);
    if (this.chosen.size === 0 && this.laws[0]) this.chosen.add(this.laws[0]);
    by('what-if-said').textContent = event.why ? `✕ ${event.why}` : '';
    by('what-if-file').textContent = event.machine ? last(event.machine) : 'no file';
    by('what-if-file').title = event.machine ?? '';
    if (event.why) {
      [this.curves, this.cloud] = [[], null];
      this.table();
      this.draw(true);
    }
    this.build();
    if (app.view === 'what-if') this.ask();
  }

  open(): void {
    this.ask();
  }

  moved(): void {
    if (app.view === 'what-if') this.ask();
  }

  get law(): string {
    return this.laws[0] ?? '';
  }

  // Returns the changed gains of the law in use, as the form takes them.
  private gains(): Record<string, string> {
    const own = [...this.values].filter(([path]) => path.startsWith(`controller.${this.law}.`));
    return Object.fromEntries(own.map(([path, value]) => [path, String(value)]));
  }

  private build(): void {
    by('what-if-laws').replaceChildren(
      ...this.laws.map((law, place) => {
        const box = element('input', { type: 'checkbox', checked: this.chosen.has(law) });
        box.oninput = () => {
          if (box.checked) this.chosen.add(law);
          else this.chosen.delete(law);
          this.ask();
        };
        return element('label', {}, box, ` ${law}${place === 0 ? ' (in use)' : ''}`);
      }),
    );
    const open = new Set(
      [...document.querySelectorAll<HTMLDetailsElement>('#knobs details[open]')].map(
        (one) => one.dataset.of,
      ),
    );
    const groups = new Map<string, Knob[]>();
    for (const knob of this.knobs) groups.set(knob.of, [...(groups.get(knob.of) ?? []), knob]);
    const first = ['joint', this.law];
    by('knobs').replaceChildren(
      ...[...groups]
        .sort(
          ([a], [b]) =>
            Number(b === this.law) - Number(a === this.law) ||
            Number(b === 'joint') - Number(a === 'joint'),
        )
        .map(([of, knobs]) => {
          const group = element('details', { open: open.size ? open.has(of) : first.includes(of) });
          group.dataset.of = of;
          const title = of === 'joint' ? 'The joint' : `Gains of ${of}`;
          group.append(
            element('summary', { textContent: title }),
            ...knobs.map((k) => this.knob(k)),
          );
          return group;
        }),
    );
    this.enable();
  }

  private knob(knob: Knob): HTMLElement {
    const { low, high, scale, value: start } = knob;
    const ratio = scale === 'ratio';
    const to = (value: number) =>
      ratio ? Math.round((STEPS * Math.log(value / low)) / Math.log(high / low)) : value;
    const of = (place: number) =>
      ratio ? Number((low * (high / low) ** (place / STEPS)).toPrecision(4)) : place;
    const id = `knob-${knob.path}`;
    const slider = element('input', { type: 'range', id, min: '0', step: '1' });
    slider.max = ratio ? String(STEPS) : String(high);
    const out = element('output');
    const show = () => {
      const value = this.values.get(knob.path) ?? start;
      slider.value = String(to(value));
      out.textContent = shown(value);
      out.classList.toggle('turned', this.values.has(knob.path));
    };
    slider.oninput = () => {
      const value = of(Number(slider.value));
      if (Number(slider.value) === to(start)) this.values.delete(knob.path);
      else this.values.set(knob.path, value);
      show();
      this.enable();
      this.ask();
    };
    slider.ondblclick = () => {
      this.values.delete(knob.path);
      show();
      this.enable();
      this.ask();
    };
    show();
    const label = element(
      'label',
      { htmlFor: id, title: knob.text.replaceAll('`', '') },
      knob.name,
    );
    return element('div', { className: 'knob' }, label, out, slider);
  }

  enable(): void {
    by<HTMLButtonElement>('what-if-reset').disabled = this.values.size === 0;
    const free = may() && app.status?.driven === false;
    by<HTMLButtonElement>('what-if-set').disabled = !free || Object.keys(this.gains()).length === 0;
  }

  // Returns the predicted move, and its start.
  private way(): { way: RequestedMotion; from: number } | null {
    const how = by<HTMLSelectElement>('what-if-way').value;
    const typed = parse(by<HTMLInputElement>('what-if-deg').value);
    const isTyped = how === 'move' || how === 'step' || how === 'ramp';
    by('what-if-deg').hidden = !isTyped;
    by('what-if-deg').ariaLabel = how === 'ramp' ? 'counts per second' : 'deg';
    if (how === 'last' && app.motion && app.hello) {
      const { way, from_counts } = app.motion;
      if (way.how === 'trajectory') return { way, from: 0 };
      const from = from_counts * app.hello.resolution_deg;
      return { way: { how: way.how, deg: way.deg - from }, from };
    }
    if (how === 'trajectory') {
      const trajectory = this.now?.trajectory;
      return trajectory ? { way: { how, trajectory }, from: 0 } : null;
    }
    if (how === 'ramp') {
      if (!typed.value || !app.hello) return null;
      return {
        way: { how: 'trajectory', trajectory: ramp(typed.value * app.hello.resolution_deg) },
        from: 0,
      };
    }
    const deg = how === 'last' ? 5 : typed.value;
    return deg !== null ? { way: { how: how === 'step' ? how : 'move', deg }, from: 0 } : null;
  }

  // Requests a prediction, one at a time: changes meanwhile are requested after the answer.
  private ask(): void {
    const now = performance.now();
    if (app.recording || this.laws.length === 0) return;
    if (this.asked && now - this.asked < PATIENCE_MS) {
      this.waits = true;
      return;
    }
    const moved = this.way();
    if (!moved) {
      const { refused } = parse(by<HTMLInputElement>('what-if-deg').value);
      by('what-if-said').textContent = `✕ ${refused ?? 'There is no such move.'}`;
      return;
    }
    this.asked = now;
    this.waits = false;
    const laws = [this.law, ...this.laws.slice(1)].filter((law) => this.chosen.has(law));
    const cloud = by<HTMLInputElement>('what-if-cloud').checked && laws.length ? CLOUD : 0;
    if (!cloud) {
      this.cloud = null;
      this.noCloud = '';
    }
    const values = Object.fromEntries(this.values);
    const { joint } = this;
    const wish = { way: moved.way, from_deg: moved.from, laws, values, cloud, joint };
    this.link.send('predict', ++this.number, { wish });
  }

  predicted({ id, part, content }: Event): void {
    if (id !== this.number) return;
    if (part === 'cloud') {
      this.cloud = content.refused ? null : content;
      this.noCloud = content.refused ? `✕ No joints around it: ${content.refused}` : '';
    }
    if (part === 'laws') this.curves = content;
    if (part === 'refused') this.curves = [];
    const refused = [
      ...(part === 'refused' ? [content] : []),
      ...this.curves.filter((one) => one.refused).map((one) => `${one.law}: ${one.refused}`),
    ];
    if (part !== 'cloud') {
      by('what-if-said').textContent = refused.map((why) => `✕ ${why}`).join('\n');
      this.asked = 0;
      if (this.waits) this.ask();
    }
    this.table();
    this.draw(true);
  }

  private table(): void {
    const row = (cells: string[], kind: 'td' | 'th' = 'td') =>
      element('tr', {}, ...cells.map((cell) => element(kind, { textContent: cell })));
    const after = (one: Curve, settled_s: number | null) =>
      one.fault
        ? `ends by a fault: ${one.fault}`
        : settled_s === null
          ? 'never'
          : `${settled_s.toFixed(2)} s`;
    const slack = this.now?.unseen_slack ?? null;
    const goal = this.now?.goal ?? 'within 2 counts until the end';
    // If the encoder cannot measure slack, both sides of the gear are shown.
    // A trajectory is also judged on its way.
    const follows = this.way()?.way.how === 'trajectory';
    const largest = (errors: number[]) =>
      errors.reduce((most, error) => Math.max(most, Math.abs(error)), 0);
    const cells = (one: Curve) => [
      ...(follows ? [shown(largest(one.error_counts))] : []),
      after(one, one.settled_s),
      shown(one.rest_counts),
      ...(slack ? [after(one, one.settled_at_load_s), shown(one.rest_at_load_counts)] : []),
    ];
    const rows = this.curves
      .filter((one) => !one.refused)
      .map((one) => row([one.law, ...cells(one)]));
    if (this.cloud) {
      const { law, curves, settled: good, worst, is_written, refused_joints: left } = this.cloud;
      const one = worst ? curves[worst.place] : null;
      if (one) rows.push(row([`worst of ${curves.length} joints, ${law}`, ...cells(one)]));
      const { success_at_encoder: encoder, success_at_load: load } = this.cloud;
      by('what-if-cloud-said').textContent =
        (slack
          ? `Of ${curves.length} joints around this one, ${encoder} meet the goal (${goal}) at the ` +
            `encoder, ${load} at the load. `
          : `${good} of ${curves.length} joints around this one settle ${tolerance(goal)}. `) +
        (is_written
          ? 'They are drawn from the [spread] of the file.'
          : 'The file has no [spread]: one is assumed.') +
        (left.length ? ` ${left.length} more cannot be armed: ${left[0]}.` : '') +
        (worst ? ` The worst has ${worst.joint.map(brief).join(', ')}.` : '');
    } else by('what-if-cloud-said').textContent = this.noCloud;
    const within = tolerance(goal);
    const heads = slack
      ? [
          `At the encoder: ${within} after`,
          'Error at the end, counts',
          `At the load: ${within} after`,
          'Error at the end, counts',
        ]
      : [
          this.now?.has_two_encoders
            ? `At the load: ${within} after`
            : `${within[0].toUpperCase()}${within.slice(1)} after`,
          'Error at the end, counts',
        ];
    if (follows) heads.unshift('Largest error, counts');
    by('what-if-table').replaceChildren(row(['Predicted', ...heads], 'th'), ...rows);
    by('what-if-slack').textContent = slack && this.curves.length ? `Note: ${slack}.` : '';
  }

  // Draws, at most at the given rate.
  draw(now = false): void {
    if (app.view !== 'what-if') return;
    if (!now && performance.now() - this.drawn < REDRAWN_MS) return;
    this.drawn = performance.now();
    const good = this.curves.filter((one) => !one.refused);
    const times = (one: Curve) => one.position_deg.map((_, k) => one.begin_s + k * one.tick_s);
    const of = (one: Curve, name: string, look: Look): MoveCurve => ({
      name,
      look,
      times: times(one),
      position: one.position_deg,
      error: one.error_counts,
      effort: one.effort_v,
      twist: one.motor_less_load_deg,
    });
    const all: MoveCurve[] = [];
    this.cloud?.curves.forEach((one, place) =>
      all.push(of(one, place === 0 ? 'joints around it' : '', OF_CLOUD)),
    );
    const worst = this.cloud?.worst;
    if (worst) all.push(of(this.cloud!.curves[worst.place], 'worst joint', OF_WORST));
    const set = good[0];
    if (set?.reference_deg)
      all.push({
        name: 'reference',
        look: LOOKS.reference,
        times: set.reference_deg.map((_, k) => set.begin_s + k * set.tick_s),
        position: set.reference_deg,
      });
    // The measurement is broad, and the predictions are drawn over it.
    const last = by<HTMLSelectElement>('what-if-way').value === 'last' ? measured() : null;
    if (last) all.push({ name: 'measured', look: OF_MEASURED, ...last });
    good.forEach((one) => {
      const place = Math.max(0, this.laws.indexOf(one.law));
      const look = { ...OF_LAWS[place % OF_LAWS.length], width: 1.6 };
      const load = one.error_at_load_counts;
      const differ = load?.some((error, k) => Math.abs(error - one.error_counts[k]) >= ONE_LINE);
      if (!load || !differ) {
        all.push(of(one, `${one.law}, predicted`, look));
        return;
      }
      all.push(of(one, `${one.law}, at the encoder`, look));
      const name = `${one.law}, at the load`;
      const position = one.position_at_load_deg ?? [];
      all.push({ name, look: { ...look, ...AT_LOAD }, times: times(one), position, error: load });
    });
    const end = Math.max(...good.map((one) => times(one).at(-1) ?? 0), 1);
    this.plots.show(all, [-0.05 * end, end]);
  }

  repaint(): void {
    this.plots.repaint();
  }
}

// Returns the tolerance of a goal: "within 2 counts" of "within 2 counts until the end".
function tolerance(goal: string): string {
  return goal.split(' ').slice(0, 3).join(' ');
}

function brief(key: string): string {
  const [path, value] = key.split('=');
  const name = path.split('.').pop();
  return `${name} ${shown(Number(value))}`;
}
