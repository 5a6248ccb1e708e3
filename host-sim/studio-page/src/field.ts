// Fields for a number. Each shows the number that it reads before Enter uses it.

import { by, element } from './app';
import { parse, reading } from './typed-number';
import { report } from './messages';

const FIELDS = [
  'trapezoid-way',
  'trapezoid-speed',
  'trapezoid-rest',
  'trapezoid-blend',
  'home-at',
  'home-effort',
  'home-travel',
  'rate',
  'holding',
  'what-if-deg',
  'selftest-moves',
  'selftest-range',
];

const readings = new Map<string, () => void>();

// Shows below a field the number that it reads, if that differs from the text.
export function shows(field: HTMLInputElement): void {
  const out = element('output', { className: 'read' });
  out.htmlFor.add(field.id);
  field.after(out);
  const show = () => {
    out.textContent = field.value.trim() === '' ? '' : reading(field.value);
    field.classList.toggle('refused', out.textContent.startsWith('✕'));
  };
  readings.set(field.id, show);
  field.addEventListener('input', show);
}

// Puts a text into a field in place of the typed one.
export function fill(id: string, text: string): void {
  by<HTMLInputElement>(id).value = text;
  readings.get(id)?.();
}

export function fields(): void {
  for (const id of FIELDS) shows(by<HTMLInputElement>(id));
}

// Returns the number of a field; an invalid text is refused with its reason.
export function number(id: string): number | null {
  const field = by<HTMLInputElement>(id);
  const { value, refused } = parse(field.value);
  if (refused === null) return value;
  report(refused, false);
  field.focus();
  return null;
}

// As `number`; undefined for an empty field.
export function numberOrNothing(id: string): number | null | undefined {
  return by<HTMLInputElement>(id).value.trim() === '' ? undefined : number(id);
}

// Field of the position, which shows the range of targets.
export class PositionField {
  private range: [number, number] | null = null;

  constructor() {
    by('deg').addEventListener('input', () => this.show());
    this.show();
  }

  // Stores the range of targets from the status, deg.
  follow(range: [number, number] | null): void {
    this.range = range;
    this.show();
  }

  private show(): void {
    const { value, refused } = parse(by<HTMLInputElement>('deg').value);
    const isOut = value !== null && this.range !== null && !within(value, this.range);
    const range = this.range ? `${this.range[0]} to ${this.range[1]} deg` : '';
    const text =
      refused !== null ? `✕ ${refused}` : `= ${value} deg${isOut ? `: ✕ it must be ${range}` : ''}`;
    if (by('deg-read').textContent !== text) by('deg-read').textContent = text;
    by('deg').classList.toggle('refused', refused !== null || isOut);
  }
}

const within = (value: number, [low, high]: [number, number]) => value >= low && value <= high;
