// The identified joint: in words, and as a machine's file for “What if”, the tuning and the
// self-test.

import { app, by, element, on } from './app';
import type { Event } from './link';
import { report } from './messages';
import { shown } from './plots';
import { download } from './session';
import { IN_PAGE } from './wire';

// The playground neither tunes nor tests.
const TAKEN = IN_PAGE
  ? '“What if” can use it; or download it, and use it with the program “stiction”.'
  : '“What if”, “Tune” and “Verify” can use it.';

// Moves of the device for its gear: those that have started, and all.
type Gear = { made: number; moves: number };
type Valued = { value: number; sd: number };

// Stiffness, slack and ratio of a gear with their standard deviations.
function gearWords(gear: Event): string {
  // The deviation has two digits, and the value as many places.
  const bar = ({ value, sd }: Valued, unit: string, factor = 1) => {
    const places = Math.min(9, Math.max(0, 1 - Math.floor(Math.log10(factor * sd || 1))));
    return `${(factor * value).toFixed(places)} ± ${(factor * sd).toFixed(places)} ${unit}`;
  };
  const stiffness = gear.si
    ? bar(gear.si.stiffness, 'N m/rad')
    : bar(gear.stiffness, 'V/deg', Math.PI / 180);
  return [
    `stiffness ${stiffness}`,
    `slack ${bar(gear.slack_deg, 'deg')}`,
    `ratio ${bar(gear.ratio, 'counts per turn')} (the device has ` +
      `${shown(gear.configured_counts_per_turn)})`,
  ].join(', ');
}

export class IdentifiedView {
  constructor() {
    on('identified-save', () => {
      const { found } = app;
      if (found?.toml) download(new Blob([found.toml], { type: 'application/toml' }), found.file);
    });
  }

  // Shows the progress of the moves for the gear, which follow the sequence. The result comes with
  // the event after them.
  progress({ made, moves }: Gear): void {
    const now = made ? `move ${made} of ${moves}` : 'the moves start when the joint is at rest';
    const text =
      'The sequence is complete. Moves with the loop closed measure the gear between the two ' +
      `encoders: ${now}. Stop or Escape ends them at once; the joint is then known without them.`;
    // A screen reader speaks every new text.
    if (by('identified-said').textContent === text) return;
    by('identified-said').className = '';
    by('identified-said').textContent = text;
    by('identified-words').hidden = true;
    by('identified-save').hidden = true;
  }

  // Shows the last result again, or none, after moves that have ended without one.
  again(): void {
    if (app.found) return this.show(app.found);
    by('identified-said').textContent = '';
  }

  show({ ok, said: words, why, file, doubts, gear, gear_refused: none }: Event): void {
    const doubtful: string[] = [
      ...(doubts ?? []),
      ...(none ? [`the gear was not identified: ${none}`] : []),
      ...(gear?.doubts ?? []),
    ];
    const ofGear = gear ? [`Gear: ${gearWords(gear)}`] : [];
    by('identified-words').textContent = words;
    by('identified-words').hidden = false;
    by('identified-said').className = ok ? (doubtful.length ? 'doubted' : 'passed') : 'failed';
    const said = ok
      ? [
          `${doubtful.length ? '⚠' : '✓'} ${file} has this joint, with its uncertainty. ${TAKEN}`,
          ...ofGear,
          ...doubtful.map((one) => `Doubtful: ${one}`),
        ]
      : [
          `✕ This is no joint for a file: ${why}.` +
            (file ? ` ${file} has the joint that was identified before.` : ''),
          ...ofGear,
        ];
    by('identified-said').textContent = said.join('\n');
    by('identified-save').textContent = `Download ${file ?? ''}`;
    by('identified-save').hidden = !file;
  }
}

const STEPS: Record<string, string> = {
  'what-if-joint': 'What if',
  'tune-joint': 'Tune',
  'selftest-joint': 'Verify',
};

// Fills a list with the joints to choose from: that of the studio's file, and the identified one.
// Returns whether the chosen joint has gone.
export function offer(id: string, file: string | null, ofFound: boolean): boolean {
  const select = by<HTMLSelectElement>(id);
  const found: string | null = (ofFound && app.found?.file) || null;
  const all: [string, string][] = [
    ...(file === null ? [] : [['file', file] as [string, string]]),
    ...(found === null ? [] : [['found', `${found}, identified`] as [string, string]]),
  ];
  const list = JSON.stringify(all);
  let isGone = false;
  if (select.dataset.all !== list) {
    const chosen = select.value;
    select.dataset.all = list;
    select.replaceChildren(
      ...all.map(([value, textContent]) => element('option', { value, textContent })),
    );
    if (all.some(([value]) => value === chosen)) select.value = chosen;
    isGone = chosen !== '' && select.value !== chosen;
    const now = all[0]?.[1] ?? 'none';
    const what = `“${STEPS[id]}”: the chosen joint is no longer available; now it is ${now}`;
    if (isGone) report(what, false, '⚠');
  }
  select.parentElement!.hidden = all.length === 0;
  return isGone;
}

// The name of a file without the directories before it.
export const last = (path: string) => path.split(/[\\/]/).pop()!;

// Doubts about the joint of a file.
export function doubted(lines: string[]): HTMLElement[] {
  return lines.map((line) => element('p', { className: 'hint', textContent: `Doubtful: ${line}` }));
}
