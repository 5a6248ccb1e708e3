// The identified joint: in words, and as a machine's file for “What if”, the tuning and the
// self-test.

import { app, by, element, on } from './app';
import type { Event } from './link';
import { report } from './messages';
import { download } from './session';
import { IN_PAGE } from './wire';

// The playground neither tunes nor tests.
const TAKEN = IN_PAGE
  ? '“What if” can use it; or download it, and use it with the program “stiction”.'
  : '“What if”, “Tune” and “Verify” can use it.';

export class IdentifiedView {
  constructor() {
    on('identified-save', () => {
      const { found } = app;
      if (found?.toml) download(new Blob([found.toml], { type: 'application/toml' }), found.file);
    });
  }

  show({ ok, said: words, why, file, doubts }: Event): void {
    const doubtful: string[] = doubts ?? [];
    by('identified-words').textContent = words;
    by('identified-words').hidden = false;
    by('identified-said').className = ok ? (doubtful.length ? 'doubted' : 'passed') : 'failed';
    by('identified-said').textContent = ok
      ? [
          `${doubtful.length ? '⚠' : '✓'} ${file} has this joint, with its uncertainty. ${TAKEN}`,
          ...doubtful.map((one) => `Doubtful: ${one}`),
        ].join('\n')
      : `✕ This is no joint for a file: ${why}.` +
        (file ? ` ${file} has the joint that was identified before.` : '');
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
