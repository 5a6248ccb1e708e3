// State of the device and of the connection that all parts of the page share.

import { History, type Hello } from './history';
import type { Event } from './link';
import type { Session } from './session';

export const by = <T extends HTMLElement = HTMLElement>(id: string) =>
  document.getElementById(id) as T;
export const on = (id: string, what: () => void) => {
  by(id).onclick = what;
};

// Data from the device while a recording is shown.
export type Aside = { history: History; motion: Event | null };

export type App = {
  hello: Hello | null;
  status: Event | null;
  // Parameters in use, as a machine's file.
  file: string | null;
  commands: boolean;
  connected: boolean;
  gone: string | null;
  recording: boolean;
  recorded: Session | null;
  aside: Aside | null;
  // A self-test moves the joint.
  testing: boolean;
  view: string;
  // The last move that started.
  motion: Event | null;
  // The last identified joint.
  found: Event | null;
};

export const history = new History();
export const app: App = {
  hello: null,
  status: null,
  file: null,
  commands: false,
  connected: false,
  gone: null,
  recording: false,
  recorded: null,
  aside: null,
  testing: false,
  view: 'live',
  motion: null,
  found: null,
};

// The device's history, shown or not.
export const live = (): History => app.aside?.history ?? history;

// Returns whether the server would accept a request of this page.
export function may(): boolean {
  return app.connected && app.commands && app.gone === null && !app.recording;
}

export function element<K extends keyof HTMLElementTagNameMap>(
  name: K,
  more: Partial<HTMLElementTagNameMap[K]> = {},
  ...inside: (string | Node)[]
): HTMLElementTagNameMap[K] {
  const made = Object.assign(document.createElement(name), more);
  made.append(...inside);
  return made;
}
