// The view of the session: keep it, open one, export pictures and numbers.

import { app, by, history, on } from './app';
import type { Hello, History } from './history';
import { mcap } from './mcap';
import { read } from './parameters';
import { png, svg } from './picture';
import type { Planes } from './planes';
import type { Plots } from './plots';
import { allEvents, putEvents, said } from './said';
import { csv, download, open, save, stamp } from './session';
import { panels } from './terms';

export type Page = {
  plots: Plots;
  planes: Planes;
  look: () => void;
  show: (view: string) => void;
  begin: (of: Hello) => void;
  windowMoved: () => void;
};

export function keep({ plots, planes, look, show, begin, windowMoved }: Page): void {
  // What takes long is written of the history as it is now. Samples go on coming meanwhile.
  const write = (id: string, kind: string, what: (of: History) => Promise<Blob>) =>
    on(id, async () => {
      if (!history.hello) return;
      const button = by<HTMLButtonElement>(id);
      button.disabled = true;
      try {
        download(await what(history.still()), `stiction-${stamp()}.${kind}`);
      } catch (error) {
        said(`${kind}: ${(error as Error).message}`, false);
      } finally {
        button.disabled = false;
      }
    });
  write('keep', 'jsonl', (of) =>
    save(of, { hello: of.hello!, file: app.file, events: [...allEvents()] }),
  );
  read(by('open'), async (text, name) => {
    try {
      const [session, opened] = await open(text);
      history.take(opened);
      app.recording = true;
      app.motion = null;
      putEvents(session.events);
      plots.build(panels(session.hello));
      planes.build();
      const length = history.length ? history.time(history.length - 1) - history.time(0) : 10;
      plots.window = { length: Math.max(0.1, length), end: plots.now };
      windowMoved();
      said(`opened ${name}: ${history.length} samples of ${session.hello.device}`, true);
      show('live');
    } catch (error) {
      // What was shown so far stays.
      said(`${name}: ${(error as Error).message}`, false);
    }
    look();
  });
  on('back', () => {
    app.recording = false;
    putEvents([]);
    if (app.hello) begin(app.hello);
    look();
  });
  const title = () => `${history.hello?.device ?? ''} – ${history.hello?.warning ?? 'measured'}`;
  write('csv', 'csv', (of) => csv(of, plots.rows));
  write('mcap', 'mcap', (of) => mcap(of, plots.rows));
  on('png', async () => {
    const picture = await png(plots, title());
    if (picture) download(picture, `stiction-${stamp()}.png`);
  });
  on('svg', () => download(svg(plots, title()), `stiction-${stamp()}.svg`));
}
