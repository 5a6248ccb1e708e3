// Splits long work into pieces. While the motor is driven, the page must send keep-alives; a page
// that computes for half a second sends none, and the device turns its output off.

const AT_MOST_MS = 15;

export class Breath {
  private begin = performance.now();

  // Lets other work of the page run if this work has taken that long.
  async take(): Promise<void> {
    if (performance.now() - this.begin < AT_MOST_MS) return;
    await new Promise((done) => setTimeout(done));
    this.begin = performance.now();
  }
}
