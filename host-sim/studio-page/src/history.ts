// Samples of the last minutes, 32 bits each, read by their form.

export type Signal = { name: string; unit: string; form: 'number' | 'whole' | 'bits' };
export type Hello = {
  generation: number;
  device: string;
  firmware: string;
  program: string;
  kind: 'simulated' | 'emulated' | 'board';
  warning: string | null;
  sample_time_s: number;
  resolution_deg: number;
  // Of the motor's encoder, if the load has another one; sessions of older programs have none.
  motor_resolution_deg?: number | null;
  every: number;
  signals: Signal[];
  law: string[];
  // Target of a current loop for an effort of 1 V; sessions of older programs have none.
  target_a_per_v?: number | null;
};
// Missing samples, or a reset of the device.
export type Gap = { begin: number; end: number; lost: number; isReset: boolean };

const MINUTES = 10;
const MOST_ROWS = 1 << 20;
const MOST_GAPS = 1000;
const ANEW_S = 0.5;
// The time that a device was off at a reset is unknown. The plots leave this much room for it.
const RESET_S = 1;
// A clock of 32 bits that has wrapped is this close to zero again, ticks.
const WRAPPED = 1 << 24;

type Column = Float32Array | Int32Array | Uint32Array;

export class History {
  hello: Hello | null = null;
  length = 0;
  lost = 0;
  resets = 0;
  gaps: Gap[] = [];
  // Number of gaps with lost samples; the list has only the last ones, and resets as well.
  gapCount = 0;
  private fresh = false;
  private room = 0;
  private begin = 0;
  private numbers = new Uint32Array(0);
  private clocks = new Uint32Array(0);
  // The clocks as one time that continues across resets, ticks.
  private ticks = new Float64Array(0);
  private offset = 0;
  private columns: Column[] = [];
  private places = new Map<string, number>();

  reset(hello: Hello): void {
    this.hello = hello;
    const wanted = (MINUTES * 60) / Math.max(hello.sample_time_s * hello.every, 1e-4);
    this.room = Math.min(MOST_ROWS, Math.ceil(wanted));
    this.numbers = new Uint32Array(this.room);
    this.clocks = new Uint32Array(this.room);
    this.ticks = new Float64Array(this.room);
    const make = { number: Float32Array, whole: Int32Array, bits: Uint32Array };
    this.columns = hello.signals.map(({ form }) => new make[form](this.room));
    this.places = new Map(hello.signals.map(({ name }, place) => [name, place]));
    this.length = this.begin = this.lost = this.gapCount = this.resets = this.offset = 0;
    this.fresh = false;
    this.gaps = [];
  }

  // Continues after another `hello`, if the signals are the same. Returns whether they are.
  goOn(hello: Hello): boolean {
    const layout = (of: Hello) =>
      JSON.stringify([of.device, of.sample_time_s, of.resolution_deg, of.every, of.signals]);
    if (!this.hello || layout(hello) !== layout(this.hello)) return false;
    // A page that was away and receives the same `hello` finds the losses by the numbers.
    if (hello.generation !== this.hello.generation) this.fresh = true;
    this.hello = hello;
    return true;
  }

  // Takes over the contents of another history.
  take(other: History): void {
    Object.assign(this, other);
  }

  // Returns a copy that later samples do not change.
  still(): History {
    const copy = new History();
    copy.take(this);
    copy.numbers = this.numbers.slice();
    copy.clocks = this.clocks.slice();
    copy.ticks = this.ticks.slice();
    copy.columns = this.columns.map((column) => column.slice());
    copy.gaps = [...this.gaps];
    return copy;
  }

  // A frame: generation, columns, rows, 0, then rows of number, clock, values.
  frame(bytes: ArrayBuffer): void {
    const words = new Uint32Array(bytes);
    const [generation, columns, rows] = words;
    if (generation !== this.hello?.generation || columns !== this.columns.length) return;
    const views = { number: new Float32Array(bytes), whole: new Int32Array(bytes), bits: words };
    const sources = this.hello.signals.map(({ form }) => views[form]);
    for (let row = 0; row < rows; row++) {
      const at = 4 + row * (2 + columns);
      this.push(words[at], words[at + 1], (column) => sources[column][at + 2 + column]);
    }
  }

  push(number: number, clock: number, value: (column: number) => number): void {
    if (this.length > 0) {
      const last = this.at(this.length - 1);
      const passed = (clock - this.clocks[last]) >>> 0;
      // A device that was reset restarts its clock.
      const isReset = clock < this.clocks[last] && passed > WRAPPED;
      // Numbers restart with a new subscription, also in a saved session.
      const isAnew = this.fresh || number <= this.numbers[last];
      let lost = 0;
      if (isReset) {
        const room = Math.ceil(RESET_S / Math.max(this.hello?.sample_time_s ?? 1, 1e-6));
        this.offset = this.ticks[last] + room - clock;
        this.resets++;
      } else {
        this.offset = this.ticks[last] + passed - clock;
        lost = isAnew ? this.unsent(passed) : number - this.numbers[last] - 1;
      }
      if (isReset || lost > 0) {
        this.lost += lost;
        if (lost > 0) this.gapCount++;
        this.gaps.push({
          begin: this.seconds(this.ticks[last]),
          end: this.timeOf(clock),
          lost,
          isReset,
        });
        if (this.gaps.length > MOST_GAPS) this.gaps.shift();
      }
    }
    this.fresh = false;
    if (this.length === this.room) this.begin = (this.begin + 1) % this.room;
    else this.length++;
    const at = this.at(this.length - 1);
    this.numbers[at] = number;
    this.clocks[at] = clock;
    this.ticks[at] = clock + this.offset;
    for (let column = 0; column < this.columns.length; column++)
      this.columns[column][at] = value(column);
  }

  // Returns the number of samples lost before restarted numbers, by their ticks. The device sends
  // none for an instant while it changes the subscription.
  private unsent(ticks: number): number {
    const every = this.hello?.every ?? 1;
    return this.seconds(ticks) > ANEW_S ? Math.max(0, Math.round(ticks / every) - 1) : 0;
  }

  private at(row: number): number {
    const at = this.begin + row;
    return at >= this.room ? at - this.room : at;
  }

  private seconds(ticks: number): number {
    return ticks * (this.hello?.sample_time_s ?? 0);
  }

  time(row: number): number {
    return this.seconds(this.ticks[this.at(row)]);
  }

  // The time of a clock since the last reset.
  timeOf(clock: number): number {
    return this.seconds(clock + this.offset);
  }

  // Returns whether the numbers at the ends of these rows show that none is missing between.
  whole(first: number, last: number): boolean {
    const [from, to] = [this.at(first), this.at(last)];
    const numbers = (this.numbers[to] - this.numbers[from]) >>> 0;
    return numbers === last - first && this.clocks[to] >= this.clocks[from];
  }

  // Returns whether no sample is missing between this row and the previous one.
  follows(row: number): boolean {
    return row > 0 && this.whole(row - 1, row);
  }

  clock(row: number): number {
    return this.clocks[this.at(row)];
  }

  number(row: number): number {
    return this.numbers[this.at(row)];
  }

  // Returns a reader of a signal by its row, valid until the next sample.
  reader(name: string): (row: number) => number {
    const place = this.places.get(name);
    if (place === undefined) return () => 0;
    const [column, begin, room] = [this.columns[place], this.begin, this.room];
    return (row) => column[begin + row >= room ? begin + row - room : begin + row];
  }

  value(name: string, row: number): number {
    return this.reader(name)(row);
  }

  raw(row: number): number[] {
    const at = this.at(row);
    return [this.numbers[at], this.clocks[at], ...this.columns.map((column) => column[at])];
  }

  // Returns whether the loop is closed in that tick. Otherwise every other signal is zero.
  armed(row: number): boolean {
    return this.arming()(row);
  }

  // Returns a reader of `armed`, valid until the next sample.
  arming(): (row: number) => boolean {
    const status = this.reader('status');
    return (row) => (status(row) & 0xff) === 2;
  }

  // Returns the first row that is not before that time.
  row(time: number): number {
    let [low, high] = [0, this.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time(middle) < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}

// Returns the least and the largest value of a piece, in their order, so that no peak is lost.
export function ends(of: (row: number) => number, first: number, last: number): [number, number] {
  let [low, high, lowAt, highAt] = [Infinity, -Infinity, first, first];
  for (let row = first; row <= last; row++) {
    const value = of(row);
    if (value < low) [low, lowAt] = [value, row];
    if (value > high) [high, highAt] = [value, row];
  }
  return lowAt <= highAt ? [low, high] : [high, low];
}
