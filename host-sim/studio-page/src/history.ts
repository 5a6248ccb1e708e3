// The samples of the last minutes, as the device has sent them: 32 bits each, read by their form.

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
  every: number;
  signals: Signal[];
  law: string[];
};
// Where samples are missing, or the device was reset.
export type Gap = { begin: number; end: number; lost: number; isReset: boolean };

const MINUTES = 10;
const MOST_ROWS = 1 << 20;
const MOST_GAPS = 1000;
const ANEW_S = 0.5;
// Nobody knows how long a device was off that was reset. That much room is left for it.
const RESET_S = 1;
// A clock of 32 bits that has come to its end is that near to its begin again.
const WRAPPED = 1 << 24;

type Column = Float32Array | Int32Array | Uint32Array;

export class History {
  hello: Hello | null = null;
  length = 0;
  lost = 0;
  resets = 0;
  gaps: Gap[] = [];
  // Of samples that are lost; the list has the last ones only, and resets as well.
  gapCount = 0;
  private fresh = false;
  private room = 0;
  private begin = 0;
  private numbers = new Uint32Array(0);
  private clocks = new Uint32Array(0);
  // The clocks as one time that goes on across resets.
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

  // The device sends anew. Samples of the same signals are added to those that there are.
  goOn(hello: Hello): boolean {
    const layout = (of: Hello) =>
      JSON.stringify([of.device, of.sample_time_s, of.resolution_deg, of.every, of.signals]);
    if (!this.hello || layout(hello) !== layout(this.hello)) return false;
    // Who was away and hears the same again has missed what its numbers say.
    if (hello.generation !== this.hello.generation) this.fresh = true;
    this.hello = hello;
    return true;
  }

  // Has from now on what another one has.
  take(other: History): void {
    Object.assign(this, other);
  }

  // The same as it is now, whatever comes.
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
      // A device that was reset begins its time anew.
      const isReset = clock < this.clocks[last] && passed > WRAPPED;
      // Numbers begin anew, also in a session that was kept, when the device was asked anew.
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

  // Samples whose numbers began anew tell what is missing by their ticks. The device sends none for
  // an instant while it is asked what it sends.
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

  // Whether nothing is missing between those rows, as far as their ends tell.
  whole(first: number, last: number): boolean {
    const [from, to] = [this.at(first), this.at(last)];
    const numbers = (this.numbers[to] - this.numbers[from]) >>> 0;
    return numbers === last - first && this.clocks[to] >= this.clocks[from];
  }

  // Whether nothing is missing between that row and the one before it.
  follows(row: number): boolean {
    return row > 0 && this.whole(row - 1, row);
  }

  clock(row: number): number {
    return this.clocks[this.at(row)];
  }

  number(row: number): number {
    return this.numbers[this.at(row)];
  }

  // Reads a signal by its row, until the next sample comes.
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

  // Whether the loop is closed in that tick. Without it every other signal is zero.
  armed(row: number): boolean {
    return this.arming()(row);
  }

  // Reads that by its row, until the next sample comes.
  arming(): (row: number) => boolean {
    const status = this.reader('status');
    return (row) => (status(row) & 0xff) === 2;
  }

  // The first row that is not before that time.
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

// The least and the largest value of a piece, in the order in which they come, so that
// no peak is lost.
export function ends(of: (row: number) => number, first: number, last: number): [number, number] {
  let [low, high, lowAt, highAt] = [Infinity, -Infinity, first, first];
  for (let row = first; row <= last; row++) {
    const value = of(row);
    if (value < low) [low, lowAt] = [value, row];
    if (value > high) [high, highAt] = [value, row];
  }
  return lowAt <= highAt ? [low, high] : [high, low];
}
