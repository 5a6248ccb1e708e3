// Whether a motor can move: in words, always, and not by colour alone. A recording that is shown
// changes nothing of that: the device is there all the same.

import type { Hello } from './history';

export type Seen = {
  // The studio itself is in the page (playground/).
  inPage: boolean;
  connected: boolean;
  gone: string | null;
  recording: boolean;
  hello: Hello | null;
  // Null if it is not known.
  driven: boolean | null;
};
type Said = [kind: string, what: string, more: string];

const RECORDING = 'A RECORDING IS SHOWN, and not the device; no button but Stop reaches a motor';

export function banner(seen: Seen): Said {
  const [kind, what, more] = device(seen);
  return seen.recording ? [kind, what, `${more}. ${RECORDING}`] : [kind, what, more];
}

function device({ inPage, connected, gone, hello, driven }: Seen): Said {
  if (inPage)
    return [
      'quiet',
      'A SIMULATION IN THIS PAGE',
      gone ?? 'no motor: nothing is connected, and every motion is simulated',
    ];
  if (!connected) {
    return hello && hello.kind !== 'board'
      ? [
          'quiet',
          'NO CONNECTION',
          'the studio has ended, or cannot be reached. No motor: the joint was simulated',
        ]
      : [
          'unknown',
          '? NO CONNECTION',
          'nothing is known of the motor. If one is there, it may be driven for as ' +
            'long as the link timeout',
        ];
  }
  if (gone !== null) return ['unknown', '? THE DEVICE DOES NOT ANSWER', gone];
  if (!hello) return ['unknown', '? CONNECTING', 'nothing is known of the motor yet'];
  if (hello.kind === 'simulated') return ['quiet', 'SIMULATED JOINT', 'simulated: no motor'];
  if (hello.kind === 'emulated')
    return [
      'quiet',
      'EMULATED MICROCONTROLLER',
      'the flash image around a simulated joint: no motor',
    ];
  if (driven === null)
    return ['unknown', '? A REAL MOTOR', 'it is not known whether it is driven: keep clear of it'];
  return driven
    ? ['driven', '▲ A REAL MOTOR IS DRIVEN', 'keep clear of the joint']
    : [
        'board',
        '● A REAL MOTOR',
        'it is off, and can be armed. Off is not still: nothing holds the joint',
      ];
}
