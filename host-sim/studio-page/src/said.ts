// What was said, and the events of the session.

import { app, by, element, live } from './app';
import type { Answer, Link } from './link';
import type { Kept } from './session';

const MOST_SAID = 30;
const MOST_EVENTS = 500;

const events: Kept[] = [];

// Those of the recording that is shown, or else of this page.
export const allEvents = () => app.recorded?.events ?? events;

export function note(what: string): void {
  const of = live();
  const clock = of.length ? of.clock(of.length - 1) : 0;
  events.push({ at: new Date().toISOString(), clock, said: what });
  if (events.length > MOST_EVENTS) events.shift();
  if (app.view === 'session') listEvents();
}

export function listEvents(): void {
  const items = allEvents().slice(-100).reverse();
  by('events').replaceChildren(
    ...items.map(({ at, said }) =>
      element('li', {}, element('time', { textContent: at.slice(11, 19) }), ` ${said}`),
    ),
  );
}

// Whether something is as it should be; a doubt is neither.
export type Grade = 'good' | 'doubtful' | 'bad';

export const MARKS: Record<Grade, string> = { good: '✓', doubtful: '⚠', bad: '✕' };
const LOOKS: Record<Grade, string> = { good: 'done', doubtful: 'doubted', bad: 'refused' };

// Says what was found, with the mark of its grade.
export function graded(what: string, grade: Grade): void {
  said(what, grade === 'good', MARKS[grade], LOOKS[grade]);
}

export function said(
  what: string,
  ok: boolean,
  mark = ok ? '✓' : '✕ Refused:',
  className = ok ? 'done' : 'refused',
): void {
  const item = element('li', { className });
  item.textContent = `${mark} ${what}`;
  by('said').prepend(item);
  while (by('said').childElementCount > MOST_SAID) by('said').lastElementChild!.remove();
  note(item.textContent);
}

// Asks for something, and says what came of it.
export async function ask(link: Link, what: string, more: object = {}): Promise<Answer> {
  const answer = await link.ask(what, more);
  said(answer.said, answer.ok);
  return answer;
}
