// The signals that can be plotted, and their looks. The colours are those of the project's figures
// (Okabe and Ito), lighter on a dark ground; dashes distinguish them without colour.

import { History, type Hello } from './history';

// Makes a reader of the term by its row, valid until the next sample.
export type Read = (of: History) => (row: number) => number;
export type Term = { name: string; unit: string; value: Read; look: Look };
export type Panel = { title: string; terms: Term[]; tall?: boolean };
export type Look = { light: string; dark: string; width: number; dash?: number[] };

export const LOOKS = {
  reference: { light: '#000000', dark: '#f2f2f2', width: 1.3, dash: [6, 4] },
  primary: { light: '#00548f', dark: '#56b4e9', width: 2 },
  second: { light: '#d55e00', dark: '#ff8f40', width: 2, dash: [10, 4] },
  third: { light: '#009e73', dark: '#2fc79a', width: 2, dash: [2, 3] },
  compensation: { light: '#b86e00', dark: '#f0b030', width: 1.8, dash: [6, 2, 1.5, 2, 1.5, 2] },
  total: { light: '#505050', dark: '#b8b8b8', width: 1.5, dash: [9, 3, 2, 3] },
} satisfies Record<string, Look>;

const ORDER = [
  LOOKS.primary,
  LOOKS.second,
  LOOKS.third,
  LOOKS.compensation,
  LOOKS.total,
  LOOKS.reference,
];

function term(name: string, unit: string, signal: string, look: Look): Term {
  return { name, unit, value: (of) => of.reader(signal), look };
}

export const position: Read = (of) => {
  const [counts, resolution] = [of.reader('counts'), of.hello!.resolution_deg];
  return (row) => counts(row) * resolution;
};

export const reference: Read = (of) => {
  const [counts, fraction] = [
    of.reader('reference_counts'),
    of.reader('reference_fraction_counts'),
  ];
  const resolution = of.hello!.resolution_deg;
  return (row) => (counts(row) + fraction(row)) * resolution;
};

export const errorCounts: Read = (of) => {
  const [error, resolution] = [of.reader('error_deg'), of.hello!.resolution_deg];
  return (row) => error(row) / resolution;
};

// Target of the current loop, A.
const targetA: Read = (of) => {
  const [applied, perVolt] = [of.reader('v_applied_v'), of.hello!.target_a_per_v!];
  return (row) => applied(row) * perVolt;
};

export function panels(hello: Hello): Panel[] {
  const all: Panel[] = [
    {
      title: 'Position, deg',
      tall: true,
      terms: [
        { name: 'position', unit: 'deg', value: position, look: LOOKS.primary },
        { name: 'reference', unit: 'deg', value: reference, look: LOOKS.reference },
      ],
    },
    {
      title: 'Error, counts',
      terms: [{ name: 'error', unit: 'counts', value: errorCounts, look: LOOKS.primary }],
    },
    {
      title: 'Effort, V',
      tall: true,
      terms: [
        term('v_PD', 'V', 'v_pd_v', LOOKS.third),
        term('v_c', 'V', 'v_c_v', LOOKS.compensation),
        term('commanded', 'V', 'v_v', LOOKS.total),
        term('applied', 'V', 'v_applied_v', LOOKS.primary),
      ],
    },
    {
      title: 'Velocity, deg/s',
      terms: [term('velocity', 'deg/s', 'velocity_deg_per_s', LOOKS.primary)],
    },
  ];
  // A device with a sensor of the motor's current sends it.
  if (hello.signals.some((signal) => signal.name === 'current_a')) {
    const terms = [term('measured', 'A', 'current_a', LOOKS.primary)];
    if (hello.target_a_per_v)
      terms.push({ name: 'target', unit: 'A', value: targetA, look: LOOKS.reference });
    all.push({ title: 'Motor current, A', terms });
  }
  // Signals of the law in use, a panel for each unit.
  const units = new Map<string, Term[]>();
  for (const name of hello.law) {
    const unit = hello.signals.find((signal) => signal.name === name)?.unit ?? '';
    const terms = units.get(unit) ?? [];
    terms.push(term(name, unit, name, ORDER[terms.length % ORDER.length]));
    units.set(unit, terms);
  }
  for (const [unit, terms] of units)
    all.push({ title: `The law's own, ${unit || 'no unit'}`, terms });
  return all;
}

export function isDark(): boolean {
  return matchMedia('(prefers-color-scheme: dark)').matches;
}

export function colour(look: Look): string {
  return isDark() ? look.dark : look.light;
}
