// Measurement of the last move, in the time of its set point.

import { app, history } from './app';
import { ends } from './history';
import { errorCounts, position, reference } from './terms';

const LONGEST_S = 60;
const MOST = 4000;
// As in prediction.rs.
const SETS_OUT_COUNTS = 1e-3;

export type Measured = {
  times: number[];
  position: number[];
  error: number[];
  effort: number[];
  // Only of a joint with two encoders.
  twist?: number[];
};

export function measured(): Measured | null {
  const { motion, hello } = app;
  if (!motion || !hello || history.length === 0) return null;
  const at = history.timeOf(motion.clock);
  // The move of another page, or one before a reset.
  if (history.time(0) > at || history.time(history.length - 1) < at) return null;
  // That tick is one before the request, so the set point had not changed.
  const first = history.row(at - 0.5 * hello.sample_time_s);
  const [lead, place, error, effort, status] = [
    reference(history),
    position(history),
    errorCounts(history),
    history.reader('v_applied_v'),
    history.reader('status'),
  ];
  const from = motion.from_counts * hello.resolution_deg;
  const on = (row: number) => (status(row) & 0xff) === 2;
  let begin = first;
  while (
    begin < history.length &&
    (!on(begin) || Math.abs(lead(begin) - from) <= SETS_OUT_COUNTS * hello.resolution_deg)
  )
    begin++;
  if (begin >= history.length) return null;
  const zero = history.time(begin);
  let end = begin;
  while (end < history.length && on(end) && history.time(end) - zero < LONGEST_S) end++;
  const piece = Math.max(1, Math.ceil((2 * (end - begin)) / MOST));
  const found: Measured = { times: [], position: [], error: [], effort: [] };
  const terms: ['position' | 'error' | 'effort' | 'twist', (row: number) => number][] = [
    ['position', place],
    ['error', error],
    ['effort', effort],
  ];
  const ofMotor = hello.motor_resolution_deg;
  if (ofMotor && hello.signals.some(({ name }) => name === 'motor_counts')) {
    const motor = history.reader('motor_counts');
    const twist = (row: number) => motor(row) * ofMotor - place(row);
    // Arming shifts the position, but not the counts of the motor.
    const before = twist(begin);
    found.twist = [];
    terms.push(['twist', (row) => twist(row) - before]);
  }
  for (let row = begin; row < end; row += piece) {
    const last = Math.min(end, row + piece) - 1;
    const rows = row === last ? [row] : [row, last];
    found.times.push(...rows.map((one) => history.time(one) - zero));
    for (const [term, of] of terms) {
      const values = row === last ? [of(row)] : ends(of, row, last);
      found[term]!.push(...values);
    }
  }
  return found;
}
