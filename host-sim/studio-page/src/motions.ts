// Buttons that move the joint: arm, hold, move, step, trajectory, jog, home, identify. A real motor
// is turned on only after a typed word, since a button may be pressed by mistake.

import { app, by, history, on } from './app';
import type { Link } from './link';
import { number, numberOrNothing } from './field';
import { ask } from './messages';
import { reference } from './terms';

const WORD = 'ARM';

let wanted: (() => void) | null = null;

// Turns the output on, at once or, for a real motor, after a confirmation.
export function turnOn(what: string, then: () => void): void {
  if (app.hello?.kind !== 'board') return then();
  wanted = then;
  by('confirm-what').textContent = what;
  by('confirm').hidden = false;
  by<HTMLInputElement>('confirm-word').value = '';
  by('confirm-word').focus();
}

export function forget(): void {
  wanted = null;
  by('confirm').hidden = true;
}

export function motions(link: Link): void {
  const go = (how: 'move' | 'step') => {
    const deg = number('deg');
    if (deg !== null) void ask(link, how, { deg });
  };
  on('arm', () => turnOn('Arm closes the loop', () => void ask(link, 'arm')));
  on('hold', () => void ask(link, 'hold'));
  on('clear', () => void ask(link, 'clear'));
  on('take-over', () => void ask(link, 'take-over'));
  on('step', () => go('step'));
  by('move').onsubmit = (event) => {
    event.preventDefault();
    go('move');
  };
  for (const nudge of document.querySelectorAll<HTMLElement>('[data-by]')) {
    nudge.onclick = () => {
      const last = history.length - 1;
      const from = last >= 0 ? reference(history)(last) : 0;
      const deg = Number((from + Number(nudge.dataset.by)).toFixed(6));
      by<HTMLInputElement>('deg').value = String(deg);
      void ask(link, 'move', { deg });
    };
  }
  on('file-trajectory', () => void ask(link, 'trajectory'));
  by('trapezoid').onsubmit = (event) => {
    event.preventDefault();
    const fields = ['way', 'speed', 'rest', 'blend'].map((name) => number(`trapezoid-${name}`));
    if (fields.every((one) => one !== null)) void ask(link, 'trajectory', { trapezoid: fields });
  };
  by('reference').onsubmit = (event) => {
    event.preventDefault();
    const deg = number('stands');
    if (deg !== null) void ask(link, 'reference', { deg });
  };
  for (const jog of document.querySelectorAll<HTMLElement>('.jog'))
    jog.onclick = () =>
      turnOn('A jog pushes the joint a little each way', () => void ask(link, 'jog'));
  by('home').onsubmit = (event) => {
    event.preventDefault();
    const at_deg = number('home-at');
    const [effort_v, travel_deg] = ['home-effort', 'home-travel'].map(numberOrNothing);
    if (at_deg === null || effort_v === null || travel_deg === null) return;
    const to = by<HTMLSelectElement>('home-to').value;
    const towards = by<HTMLSelectElement>('home-towards').value;
    turnOn(
      'The homing goes to its place, with a bounded effort',
      () => void ask(link, 'home', { home: { to, towards, at_deg, effort_v, travel_deg } }),
    );
  };
  for (const identify of document.querySelectorAll<HTMLElement>('.identify'))
    identify.onclick = () => {
      const gear = app.hello?.motor_resolution_deg
        ? ', and measures the gear between the two encoders by moves with the loop closed'
        : '';
      turnOn(
        `The identification moves the joint to and fro, for minutes${gear}`,
        () => void ask(link, 'identify'),
      );
    };
  by('ramp').onsubmit = (event) => {
    event.preventDefault();
    const [rate, hold] = [number('rate'), number('holding')];
    if (rate === null || hold === null) return;
    turnOn(
      'A ramp raises the effort until the joint moves',
      () => void ask(link, 'identify', { rate, hold }),
    );
  };
  by('confirm').onsubmit = (event) => {
    event.preventDefault();
    const typed = by<HTMLInputElement>('confirm-word').value.trim().toUpperCase();
    const then = wanted;
    if (typed !== WORD || !then) return by('confirm-word').focus();
    forget();
    then();
  };
  on('confirm-not', forget);
}
