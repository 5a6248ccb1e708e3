// View of the session: save it, open one, export pictures and numbers.

import { app, by, element, history, on } from './app';
import { History } from './history';
import { mcap } from './mcap';
import { read } from './parameters';
import { png, svg } from './picture';
import type { Plots } from './plots';
import { allEvents, listEvents, report } from './messages';
import { csv, download, open, save, stamp } from './session';

export type Page = {
  plots: Plots;
  look: () => void;
  show: (view: string) => void;
  redraw: () => void;
  windowMoved: () => void;
};

export function keep({ plots, look, show, redraw, windowMoved }: Page): void {
  // Long work uses a copy of the history, since samples go on arriving.
  const write = (id: string, kind: string, what: (of: History) => Promise<Blob>) =>
    on(id, async () => {
      if (!history.hello) return;
      const button = by<HTMLButtonElement>(id);
      button.disabled = true;
      try {
        download(await what(history.still()), `stiction-${stamp()}.${kind}`);
      } catch (error) {
        report(`${kind}: ${(error as Error).message}`, false);
      } finally {
        button.disabled = false;
      }
    });
  write('keep', 'jsonl', (of) =>
    save(of, {
      saved: app.recorded?.saved ?? new Date().toISOString(),
      hello: of.hello!,
      file: app.recorded ? app.recorded.file : app.file,
      events: [...allEvents()],
    }),
  );
  read(by('open'), async (text, name) => {
    try {
      const [session, opened] = await open(text);
      // The device's samples are still recorded beside it.
      if (!app.aside) {
        const device = new History();
        device.take(history);
        app.aside = { history: device, motion: app.motion };
      }
      history.take(opened);
      app.recording = true;
      app.recorded = session;
      app.motion = null;
      showRecorded();
      redraw();
      const length = history.length ? history.time(history.length - 1) - history.time(0) : 10;
      plots.window = { length: Math.max(0.1, length), end: plots.now };
      windowMoved();
      const { device, firmware } = session.hello;
      report(`opened ${name}: ${history.length} samples of ${device}, firmware ${firmware}`, true);
      show('live');
    } catch (error) {
      // The previous view stays.
      report(`${name}: ${(error as Error).message}`, false);
    }
    look();
  });
  on('back', () => {
    const { aside } = app;
    if (!aside) return;
    history.take(aside.history);
    app.motion = aside.motion;
    app.aside = app.recorded = null;
    app.recording = false;
    showRecorded();
    redraw();
    listEvents();
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

// Shows the origin of the recording, and the parameters of its device.
function showRecorded(): void {
  const of = app.recorded;
  by('recorded').hidden = of === null;
  by('events-title').textContent = of ? 'Events of the recording' : 'Events';
  if (!of) return;
  const { device, firmware, program, warning, sample_time_s, every } = of.hello;
  const ticks = every > 1 ? `, of which 1 of ${every} was sent` : '';
  const rows: [string, string][] = [
    ['Saved', of.saved ?? 'time not recorded'],
    ['Device', warning ? `${device} (${warning})` : device],
    ['Firmware', firmware],
    ['Studio', `stiction ${program}`],
    ['Ticks', `of ${+(1e3 * sample_time_s).toPrecision(6)} ms${ticks}`],
  ];
  by('recorded-what').replaceChildren(
    ...rows.flatMap(([name, value]) => [
      element('dt', { textContent: name }),
      element('dd', { textContent: value }),
    ]),
  );
  by('recorded-file').textContent =
    of.file ?? 'Not recorded: the parameters were unknown, or could not be written as a file.';
}
