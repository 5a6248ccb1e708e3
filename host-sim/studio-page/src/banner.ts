// Banner that states in words, not only by colour, whether a motor can move. A recording does not
// change it, since the device is still there.

import type { Hello } from './history';

export type BannerState = {
  // The studio itself is in the page (playground/).
  inPage: boolean;
  connected: boolean;
  gone: string | null;
  recording: boolean;
  hello: Hello | null;
  // Null if unknown.
  driven: boolean | null;
};
type BannerText = [kind: string, what: string, more: string];

const RECORDING = 'A RECORDING IS SHOWN, not the device; only Stop acts on the motor';

export function banner(seen: BannerState): BannerText {
  const [kind, what, more] = device(seen);
  return seen.recording ? [kind, what, `${more}. ${RECORDING}`] : [kind, what, more];
}

function device({ inPage, connected, gone, hello, driven }: BannerState): BannerText {
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
          'the state of the motor is unknown. If there is one, it may be driven until the ' +
            'link timeout ends',
        ];
  }
  if (gone !== null) return ['unknown', '? THE DEVICE DOES NOT ANSWER', gone];
  if (!hello) return ['unknown', '? CONNECTING', 'the state of the motor is unknown'];
  if (hello.kind === 'simulated') return ['quiet', 'SIMULATED JOINT', 'simulated: no motor'];
  if (hello.kind === 'emulated')
    return [
      'quiet',
      'EMULATED MICROCONTROLLER',
      'the flash image around a simulated joint: no motor',
    ];
  if (driven === null)
    return ['unknown', '? A REAL MOTOR', 'it may be driven: keep clear of the joint'];
  return driven
    ? ['driven', '▲ A REAL MOTOR IS DRIVEN', 'keep clear of the joint']
    : [
        'board',
        '● A REAL MOTOR',
        'it is off, and can be armed. Off is not still: nothing holds the joint',
      ];
}
