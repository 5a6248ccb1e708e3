// Connection to the studio. The page answers each message about the device with a keep-alive, at
// most twenty a second: while the motor is driven, this keeps the device's link alive. A page that
// hangs sends none, and the device turns its output off. Messages about the server's own work are
// not answered.

import { connect, type Wire } from './wire';

const KEEP_ALIVE_MS = 50;
// As in request.rs.
export const LARGEST = 64 * 1024;
const WITHOUT_KEEP_ALIVE = new Set([
  'answer',
  'gone',
  'identified',
  'predicted',
  'role',
  'selftest',
  'tuned',
  'tuning',
  'what-if',
]);

export type Event = { event: string; [key: string]: any };
export type Answer = { ok: boolean; said: string };

export class Link {
  private wire: Wire | null = null;
  private number = 0;
  private waiting = new Map<number, (answer: Answer) => void>();
  private lastKeepAlive = 0;

  constructor(
    private readonly onEvent: (event: Event) => void,
    private readonly samples: (frame: ArrayBuffer) => void,
    // With a reason the studio has ended finally.
    private readonly cut: (why?: string) => void,
  ) {}

  get open(): boolean {
    return this.wire?.open ?? false;
  }

  connect(): void {
    const news = (data: string | ArrayBuffer) => {
      const event: Event | null = typeof data === 'string' ? JSON.parse(data) : null;
      const now = performance.now();
      const isAnswered = !WITHOUT_KEEP_ALIVE.has(event?.event ?? '');
      if (isAnswered && now - this.lastKeepAlive >= KEEP_ALIVE_MS) {
        this.lastKeepAlive = now;
        wire.send('{"do":"alive"}');
      }
      if (event) this.event(event);
      else this.samples(data as ArrayBuffer);
    };
    const cut = (why?: string) => {
      if (this.wire !== wire) return;
      for (const answered of this.waiting.values())
        answered({ ok: false, said: why ?? 'the connection to the studio is cut' });
      this.waiting.clear();
      this.cut(why);
      if (why === undefined) setTimeout(() => this.connect(), 1000);
    };
    const wire = connect(news, cut);
    this.wire = wire;
  }

  ask(what: string, more: object = {}): Promise<Answer> {
    if (!this.open)
      return Promise.resolve({ ok: false, said: `${what}: there is no connection to the studio` });
    const id = ++this.number;
    const message = JSON.stringify({ id, do: what, ...more });
    const bytes = new TextEncoder().encode(message).length;
    // The server would close the connection, even while the motor is driven.
    if (bytes > LARGEST) {
      const [has, most] = [Math.ceil(bytes / 1024), LARGEST / 1024];
      const said = `${what}: the message has ${has} KiB; it must have at most ${most} KiB`;
      return Promise.resolve({ ok: false, said });
    }
    this.wire!.send(message);
    return new Promise((answered) => this.waiting.set(id, answered));
  }

  // Sends a request that has no answer with its number.
  send(what: string, id: number, more: object): void {
    if (this.open) this.wire!.send(JSON.stringify({ id, do: what, ...more }));
  }

  private event(event: Event): void {
    if (event.event !== 'answer') return this.onEvent(event);
    this.waiting.get(event.id)?.({ ok: event.ok, said: event.said });
    this.waiting.delete(event.id);
  }
}
