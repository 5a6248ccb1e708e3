// Long work in pieces. While the motor is driven the page has to give words, and a page that
// computes for half a second gives none: the device would turn its output off.

const AT_MOST_MS = 15;

export class Breath {
  private begin = performance.now();

  // Lets the page live if it was busy for so long.
  async take(): Promise<void> {
    if (performance.now() - this.begin < AT_MOST_MS) return;
    await new Promise((done) => setTimeout(done));
    this.begin = performance.now();
  }
}
