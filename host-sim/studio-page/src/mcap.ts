// The samples of the live view as an MCAP file, for Foxglove and PlotJuggler: a topic `signals` of
// JSON messages, one for each tick with the loop. For other ticks only the time is known.

import { McapWriter } from '@mcap/core';
import { Breath } from './breath';
import type { History } from './history';
import { PIECE } from './session';
import { position, reference } from './terms';

// Output of the writer: pieces, and their total length.
class Pieces {
  readonly all: Uint8Array<ArrayBuffer>[] = [];
  private length = 0n;

  position(): bigint {
    return this.length;
  }

  async write(piece: Uint8Array): Promise<unknown> {
    this.all.push(new Uint8Array(piece));
    this.length += BigInt(piece.length);
    return undefined;
  }
}

// Times are those of the device, ns since its power-on: it has no date. After a reset they continue
// as on the page.
export async function mcap(of: History, [first, end]: [number, number]): Promise<Blob> {
  const hello = of.hello!;
  const pieces = new Pieces();
  const writer = new McapWriter({ writable: pieces });
  await writer.start({ profile: '', library: `stiction studio ${hello.program}` });
  await writer.addMetadata({
    name: 'device',
    metadata: new Map([
      ['device', hello.device],
      ['firmware', hello.firmware],
      ['warning', hello.warning ?? ''],
    ]),
  });
  const names = ['reference_deg', 'position_deg', ...hello.signals.map((signal) => signal.name)];
  const schema = {
    type: 'object',
    properties: Object.fromEntries(names.map((name) => [name, { type: 'number' }])),
  };
  const schemaId = await writer.registerSchema({
    name: 'stiction.signals',
    encoding: 'jsonschema',
    data: new TextEncoder().encode(JSON.stringify(schema)),
  });
  const channelId = await writer.registerChannel({
    schemaId,
    topic: 'signals',
    messageEncoding: 'json',
    metadata: new Map(),
  });
  const readers = [
    reference(of),
    position(of),
    ...hello.signals.map(({ name }) => of.reader(name)),
  ];
  const text = new TextEncoder();
  const breath = new Breath();
  const armed = of.arming();
  for (let row = first; row < end; row++) {
    if (row % PIECE === 0) await breath.take();
    if (!armed(row)) continue;
    const time = BigInt(Math.round(of.time(row) * 1e6)) * 1000n;
    const values = Object.fromEntries(names.map((name, place) => [name, readers[place](row)]));
    await writer.addMessage({
      channelId,
      sequence: of.number(row),
      logTime: time,
      publishTime: time,
      data: text.encode(JSON.stringify(values)),
    });
  }
  await writer.end();
  return new Blob(pieces.all, { type: 'application/octet-stream' });
}
