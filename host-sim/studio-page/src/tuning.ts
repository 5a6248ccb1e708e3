// Tuning: the server tunes gains on simulated joints, as `stiction tune` does. Nothing moves, and
// nothing is set.

import { app, by, element, on } from './app';
import { count } from './count';
import { number } from './field';
import { last, offer } from './identified';
import type { Event, Link } from './link';
import { shown } from './plots';
import { ask, reportGraded, MARKS, report, type Grade } from './messages';
import { download } from './session';

type Figures = {
  cases: number;
  successes_at_encoder: number;
  successes_at_load: number;
  settled_at_encoder_s: number;
  settled_at_load_s: number;
  tracking_at_encoder_counts: number | null;
  tracking_at_load_counts: number | null;
  rest_at_encoder_counts: number;
  rest_at_load_counts: number;
  chatter_v_per_s: number;
  held_v: number;
};
type Side = 'encoder' | 'load';
type Tuned = {
  better: boolean;
  outcome: 'tuned' | 'kept' | 'refused';
  // Why no gains were found, and a remedy.
  reason: string | null;
  gains: Record<string, { from: number; to: number }>;
  before: Figures;
  after: Figures;
  tried: number;
  gain_margins: [number, number];
  worst: {
    drawn: string[];
    delay_samples: number;
    settled_at_encoder_s: number | null;
    rest_at_encoder_counts: number;
    rest_at_load_counts: number;
    fault: string | null;
  } | null;
};

const ALL = 'all of the file';
const HEAD = ['', 'success, %', 'settled, s', 'tracking, counts', 'rest, counts'];
const MORE = ['chatter, V/s', 'held, V'];
// The limits of `stiction tune --limit`.
const LIMITS = [
  ['settling_s', 'settled, s'],
  ['tracking_counts', 'tracking, counts'],
  ['rest_counts', 'rest, counts'],
  ['chatter_v_per_s', 'chatter, V/s'],
  ['held_v', 'held, V'],
];
const JOINTS = 8;

export class Tuning {
  private running = false;
  private why: string | null = null;
  private file: Event | null = null;
  private laws = '';
  private pictures: string[] = [];

  constructor(
    private readonly link: Link,
    // Puts gains into the form, and returns how many differ from those in use.
    private readonly put: (gains: Record<string, number>) => number,
  ) {
    on('tune-start', () => void this.start());
    on('tune-cancel', () => void ask(this.link, 'cancel-tuning'));
    by('tune-joint').onchange = () => this.whose();
    const field = (id: string, label: string, more: object) =>
      element('label', {}, `${label} `, element('input', { id, autocomplete: 'off', ...more }));
    by('tune-limits').append(
      ...LIMITS.map(([name, label]) => field(`tune-${name}`, label, { placeholder: 'no limit' })),
      field('tune-cases', 'joints', {
        value: String(JOINTS),
        title: 'The gains are tuned on this number, and judged on three times as many',
      }),
    );
  }

  private async start(): Promise<void> {
    const value = (id: string) => by<HTMLSelectElement>(id).value;
    const law = value('tune-law');
    const limits: string[] = [];
    for (const [name] of LIMITS) {
      if (value(`tune-${name}`).trim() === '') continue;
      const most = number(`tune-${name}`);
      if (most === null) return;
      limits.push(`${name}=${most}`);
    }
    const cases = number('tune-cases');
    if (cases === null) return;
    if (!Number.isInteger(cases) || cases < 0)
      return report(`${count(cases, 'joint')}: it must be a whole number from 1 to 1000`, false);
    const laws = law === ALL ? [] : [law];
    const joint = value('tune-joint') || 'file';
    await ask(this.link, 'tune', { laws, goal: value('tune-goal'), joint, limits, cases });
  }

  // Shows what can be tuned, and the progress.
  update(event: Event): void {
    const { why, running } = event;
    this.file = event;
    if (running && !this.running) this.clear();
    this.running = running !== null;
    this.whose();
    // A screen reader does not speak the count.
    by('tune-count').textContent = running ? `${count(running.tried, 'set')} of gains tried` : '';
    if (running)
      this.say(
        `${running.law}, law ${running.place} of ${running.of}, for ${running.goal}, ` +
          `with the joint of ${last(running.machine)}`,
      );
    else if (this.why) this.say(`✕ ${why}`);
    this.enable();
  }

  private say(text: string): void {
    if (by('tune-said').textContent !== text) by('tune-said').textContent = text;
  }

  // Updates the list of joints, and the laws of the chosen one.
  whose(): void {
    const { file } = this;
    if (!file) return;
    offer('tune-joint', file.why === null ? last(file.machine) : null, file.of_found);
    const joint = by<HTMLSelectElement>('tune-joint').value;
    this.why = joint === '' ? file.why : null;
    const laws: string[] = joint === 'found' ? app.found!.laws : file.laws;
    const list = JSON.stringify(laws);
    if (list !== this.laws) {
      this.laws = list;
      const option = (law: string) => element('option', { value: law, textContent: law });
      const all = laws.length === 1 ? [] : [option(ALL)];
      by('tune-law').replaceChildren(...laws.map(option), ...all);
      delete by('tune-law').dataset.chosen;
    }
    // The message that there was no joint is obsolete.
    if (this.why === null && by('tune-said').textContent === `✕ ${file.why}`) this.say('');
    this.enable();
  }

  // Preselects the law of the device.
  prefer(law: string): void {
    const select = by<HTMLSelectElement>('tune-law');
    if (!select.dataset.chosen && [...select.options].some(({ value }) => value === law)) {
      select.value = law;
      select.dataset.chosen = law;
    }
  }

  enable(): void {
    const free = app.connected && !this.running && this.why === null;
    for (const id of ['tune-joint', 'tune-law', 'tune-goal', 'tune-start', 'tune-cases'])
      by<HTMLButtonElement>(id).disabled = !free;
    for (const [name] of LIMITS) by<HTMLInputElement>(`tune-${name}`).disabled = !free;
    by('tune-cancel').hidden = by('tune-runs').hidden = !this.running;
    const put = by('tune-result').querySelectorAll<HTMLElement>('[data-law]');
    for (const one of put) {
      const there = this.isInUse(one.dataset.law!);
      one.querySelector('button')!.hidden = !there;
      one.querySelector('p')!.hidden = there;
    }
  }

  private isInUse(law: string): boolean {
    return document.querySelector(`#form [data-table="controller.${CSS.escape(law)}"]`) !== null;
  }

  private clear(): void {
    this.pictures.forEach((url) => URL.revokeObjectURL(url));
    this.pictures = [];
    by('tune-result').replaceChildren();
  }

  // Shows the last result.
  found(event: Event): void {
    by('tune-count').textContent = '';
    this.clear();
    if (!event.ok) {
      this.say(`${MARKS.bad} ${event.said}`);
      if (this.running) reportGraded(event.said, 'bad');
      return;
    }
    const all: [string, Tuned][] = Object.entries(event.result.controllers);
    const refused = all.filter(([, tuned]) => isRefused(tuned));
    const grade: Grade =
      refused.length === all.length
        ? 'bad'
        : event.doubts.length || refused.length
          ? 'doubtful'
          : 'good';
    const words = [
      ...(all.some(([, tuned]) => isBetter(tuned)) ? [event.said] : []),
      ...all
        .filter(([, tuned]) => !isBetter(tuned))
        .map(([law, tuned]) => `${law}: ${refusal(tuned)}`),
      ...(event.unseen_slack ? [event.unseen_slack] : []),
      ...event.doubts.map((one: string) => `Doubtful: ${one}`),
    ].join('\n');
    this.say(`${MARKS[grade]} ${words}`);
    if (this.running) reportGraded(words, grade);
    const save = element('button', { id: 'tune-save', textContent: `Download ${event.file}` });
    save.onclick = () => download(new Blob([event.toml], { type: 'application/toml' }), event.file);
    const picture = (svg: string, place: number) => {
      const url = URL.createObjectURL(new Blob([svg], { type: 'image/svg+xml' }));
      this.pictures.push(url);
      const title = new DOMParser().parseFromString(svg, 'image/svg+xml').querySelector('text');
      const alt = `${title?.textContent ?? 'Gains tried'}, ${place + 1} of ${event.charts.length}`;
      return element('img', { src: url, alt, loading: 'lazy' });
    };
    const pictures = element('details', { className: 'pictures' });
    pictures.append(
      element('summary', { textContent: 'What was tried, and its Pareto front' }),
      ...event.charts.map(picture),
    );
    by('tune-result').append(
      element('p', {
        className: 'hint',
        textContent:
          `All simulated, tuned for ${event.goal} with the joint of ${last(event.machine)}` +
          `${event.joint === 'found' ? ', which was identified' : ''}. The gains are judged at the ` +
          `encoder. The figures are of ` +
          `${event.joints} joints on which the gains were not tuned, each with and without a ` +
          `sample of delay: ${event.spreads.map(brief).join(', ')}.`,
      }),
      ...all.map(([law, tuned]) => this.law(law, tuned)),
      ...(event.toml !== null ? [element('div', { className: 'tools' }, save)] : []),
      ...(event.charts.length ? [pictures] : []),
    );
    this.enable();
  }

  private law(law: string, tuned: Tuned): HTMLElement {
    const { gains, before, after, tried, gain_margins, worst } = tuned;
    const better = isBetter(tuned);
    const [least, most] = gain_margins;
    const box = element('section', { className: 'tuned' });
    const what = better ? 'better gains were found' : refusal(tuned);
    box.append(element('h3', { textContent: `${law}: ${what}` }));
    if (better)
      box.append(
        table(
          ['gain', 'file', 'tuned'],
          Object.entries(gains).map(([key, { from, to }]) => [key, shown(from), shown(to)]),
        ),
      );
    box.append(
      table([...HEAD, ...MORE], [...rows('file', before), ...(better ? rows('tuned', after) : [])]),
    );
    const words = [`${count(tried, 'set')} of gains ${tried === 1 ? 'was' : 'were'} tried.`];
    if (least < most)
      words.push(
        `With a sample of delay it succeeds from ${shown(least)} to ${shown(most)} times the ` +
          'joint’s gain.',
      );
    if (worst) {
      const { settled_at_encoder_s: settled_s, fault, drawn, delay_samples } = worst;
      const [encoder, load] = [worst.rest_at_encoder_counts, worst.rest_at_load_counts];
      const settles = settled_s === null ? 'never settles' : `settles in ${shown(settled_s)} s`;
      const sides = encoder === load ? '' : ` at the encoder, ${shown(load)} at the load`;
      const ends = fault ? `, ${fault}` : '';
      words.push(
        `The worst joint ${settles} and rests ${shown(encoder)} counts off${sides}${ends}; ` +
          `it has ${[...drawn.map(brief), `delay ${delay_samples}`].join(', ')}.`,
      );
    }
    box.append(element('p', { className: 'hint', textContent: words.join(' ') }));
    if (better) {
      const put = element('button', { textContent: `Put the gains of ${law} into the form` });
      put.onclick = () => {
        const entries = Object.entries(gains).map(([key, { to }]) => [
          `controller.${law}.${key}`,
          to,
        ]);
        const changed = this.put(Object.fromEntries(entries));
        report(
          changed
            ? `the form has ${count(changed, 'new gain')}; “Set” sends them to the device`
            : 'the device already has these gains',
          true,
        );
      };
      const other = element('p', {
        className: 'hint',
        textContent:
          `The device runs another law than ${law}. Push the new file to change that: the device ` +
          'uses the first law of its list.',
      });
      const row = element('div', {}, put, other);
      row.dataset.law = law;
      box.append(row);
    }
    return box;
  }
}

const isRefused = ({ outcome }: Tuned) => outcome === 'refused';
const isBetter = ({ outcome }: Tuned) => outcome === 'tuned';
const refusal = (one: Tuned) =>
  `${isRefused(one) ? 'no gains were found' : 'nothing is better'}, ` +
  `the file’s gains stay: ${one.reason}`;

// Rows of both sides of the gear, if they differ.
function rows(name: string, of: Figures): string[][] {
  const [encoder, load] = [figures(of, 'encoder'), figures(of, 'load')];
  return String(encoder) === String(load)
    ? [[name, ...encoder]]
    : [
        [`${name}, at the encoder`, ...encoder],
        [`${name}, at the load`, ...load],
      ];
}

function figures(of: Figures, side: Side): string[] {
  const tracking = of[`tracking_at_${side}_counts`];
  return [
    ((100 * of[`successes_at_${side}`]) / Math.max(1, of.cases)).toFixed(1),
    of[`settled_at_${side}_s`].toFixed(3),
    tracking === null ? '–' : tracking.toFixed(2),
    of[`rest_at_${side}_counts`].toFixed(2),
    of.chatter_v_per_s.toFixed(2),
    of.held_v.toFixed(3),
  ];
}

export function table(head: string[], rows: string[][]): HTMLElement {
  const row = (cells: string[], kind: 'td' | 'th') =>
    element('tr', {}, ...cells.map((cell) => element(kind, { textContent: cell })));
  const made = element('table', {}, row(head, 'th'), ...rows.map((cells) => row(cells, 'td')));
  return element('div', { className: 'wide' }, made);
}

export function brief(key: string): string {
  const [path, value] = key.split('=');
  const one = Number(value);
  const written = Number.isFinite(one) ? shown(one) : value.replace('..', ' to ');
  return `${path.split('.').pop()} ${written}`;
}
