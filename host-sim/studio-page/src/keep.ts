// The view of the session: keep it, open one, export pictures and numbers.

import { app, by, history, on } from './app';
import type { Hello } from './history';
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
  on('keep', () => {
    if (!history.hello) return;
    const kept = { hello: history.hello, file: app.file, events: allEvents() };
    download(save(history, kept), `stiction-${stamp()}.jsonl`);
  });
  read(by('open'), (text, name) => {
    try {
      const session = open(text, history);
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
      said(`${name}: ${(error as Error).message}`, false);
      if (app.hello && !app.recording) begin(app.hello);
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
  on('csv', () => download(csv(history, plots.rows), `stiction-${stamp()}.csv`));
  on('mcap', async () => download(await mcap(history, plots.rows), `stiction-${stamp()}.mcap`));
  on('png', async () => {
    const picture = await png(plots, title());
    if (picture) download(picture, `stiction-${stamp()}.png`);
  });
  on('svg', () => download(svg(plots, title()), `stiction-${stamp()}.svg`));
}
