// Messages on the page, and the events of the session.

import { app, by, element, live } from './app';
import type { Answer, Link } from './link';
import type { SessionEvent } from './session';

const MOST_SAID = 30;
const MOST_EVENTS = 500;

const events: SessionEvent[] = [];

// Events of the recording that is shown, or of this page.
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

// Grade of a result; a doubtful result is usable.
export type Grade = 'good' | 'doubtful' | 'bad';

export const MARKS: Record<Grade, string> = { good: '✓', doubtful: '⚠', bad: '✕' };
const LOOKS: Record<Grade, string> = { good: 'done', doubtful: 'doubted', bad: 'refused' };

// Shows a result with the mark of its grade.
export function reportGraded(what: string, grade: Grade): void {
  report(what, grade === 'good', MARKS[grade], LOOKS[grade]);
}

export function report(
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

// Sends a request, and shows its answer.
export async function ask(link: Link, what: string, more: object = {}): Promise<Answer> {
  const answer = await link.ask(what, more);
  report(answer.said, answer.ok);
  return answer;
}
