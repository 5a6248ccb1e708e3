// Commissioning of a new joint in steps, a page for each: instructions, a picture, and the button
// that executes the step. Beside it is the command that does the same. If the command drives the
// device, the studio must be ended before.

import { app, by, element, on } from './app';
import { IN_PAGE } from './wire';

type Step = {
  title: string;
  picture: string;
  text: string[];
  // Text for the playground, if it cannot do what `text` describes.
  inPage?: string[];
  // Buttons that are elsewhere on the page: labels here, and the elements that they press.
  buttons?: [label: string, then: string][];
  command?: string;
  // The command does not use the device.
  alone?: boolean;
  live?: boolean;
  // View below the step.
  here?: (typeof HERE)[number];
};

const HERE = ['identified', 'tuning', 'selftest'] as const;

const joint = (x: number, angle: number) => {
  const [dx, dy] = [24 * Math.cos(angle), -24 * Math.sin(angle)].map((one) => one.toFixed(1));
  return (
    `<g transform="translate(${x} 60)"><circle r="26" class="body"/>` +
    `<path d="M0 0L${dx} ${dy}" class="ink"/><circle r="3" class="dot"/></g>`
  );
};
const box = (x: number, y: number, width: number, text: string) =>
  `<rect x="${x}" y="${y}" width="${width}" height="34" rx="4" class="body"/><text ` +
  `x="${x + width / 2}" y="${y + 21}">${text}</text>`;
const arrow = (path: string) => `<path d="${path}" class="ink" marker-end="url(#tip)"/>`;
const picture = (inside: string) =>
  `<svg viewBox="0 0 320 120" role="img" aria-hidden="true"><defs><marker id="tip" ` +
  `viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" ` +
  `orient="auto"><path d="M0 0L8 4L0 8z" class="tip"/></marker></defs>${inside}</svg>`;

const IDENTIFIES =
  'The device measures breakaway, friction, inertia and load by a bounded sequence of motions ' +
  'without a loop. It takes minutes, and ends automatically. The result appears below, with a ' +
  'verdict. With an encoder on the motor and one on the load, moves with the loop closed follow, ' +
  'and measure the ratio, the slack and the stiffness of the gear. Stop or Escape ends all of it.';

const STEPS: Step[] = [
  {
    title: 'Wiring',
    picture: picture(
      box(6, 43, 62, 'board') +
        arrow('M68 52H110') +
        box(112, 34, 62, 'bridge') +
        arrow('M174 52H222') +
        joint(252, 0.6) +
        arrow('M252 92V108H37V80'),
    ),
    text: [
      'Leave the supply of the motor off. Check the wires against docs/reference/wiring.md.',
      'Turn the joint by hand. The number below must follow, and return to the same value ' +
        'after there and back. If it does not change or flickers by one, a wire of the ' +
        'encoder is loose.',
      'Then turn on the supply, and keep clear of the joint.',
    ],
    command: 'stiction device --port DEV status',
    live: true,
  },
  {
    title: 'Direction',
    picture: picture(
      joint(160, 1.2) +
        arrow('M122 92A46 46 0 0 1 118 36') +
        arrow('M198 36A46 46 0 0 1 198 92') +
        '<text x="160" y="112">a little each way</text>',
    ),
    text: [
      'A loop whose encoder counts against its motor runs away. A jog checks this ' +
        'without a loop: it pushes the joint a little each way, within the bounds of [jog].',
      'If the two disagree, the jog reports which of encoder.direction and drive.direction to set.',
    ],
    buttons: [['Jog', '.jog']],
    command: 'stiction device --port DEV jog',
  },
  {
    title: 'Limits',
    picture: picture(
      '<path d="M40 96H280" class="ink"/><path d="M70 26V96M250 26V96" class="bound"/>' +
        '<path d="M70 84C110 84 120 44 160 44S210 84 250 40" class="curve"/>' +
        '<text x="70" y="112">least</text><text x="250" y="112">most</text>',
    ),
    text: [
      'Set the range of the joint (limits.position_min_deg, ' +
        'limits.position_max_deg), its speed (limits.overspeed_deg_per_s, profile.*), ' +
        'and its continuous effort (limits.continuous_v).',
      'The range counts from where the joint stands at each reset. With device.reference = ' +
        '"command", it counts from a position that you set with the motor off, or from a ' +
        'place that “Home” finds. Both are under “First motion and friction”. After a ' +
        'reset no motion starts until the joint has this reference.',
      'Keep limits.link_timeout_s on: it turns the motor off when this page is gone.',
    ],
    buttons: [['Show the limits', 'limits']],
  },
  {
    title: 'Identify',
    picture: picture(
      '<path d="M40 100V16M40 100H290" class="ink"/><path d="M40 92L150 36" ' +
        'class="curve"/><path d="M150 36V62L270 48" class="curve"/>' +
        '<text x="166" y="30">breakaway</text><text x="232" ' +
        'y="78">sliding</text><text x="96" y="112">effort, then speed</text>',
    ),
    text: [
      IDENTIFIES,
      'The identified joint is available as a machine’s file at once. Choose it in the next steps ' +
        'to use it. Download it to keep it: it is lost when the studio ends.',
    ],
    inPage: [
      IDENTIFIES,
      'The identified joint is available as a machine’s file at once. Download it, and use the ' +
        'program “stiction” on a computer to tune and test with it: it is lost when this page is ' +
        'closed.',
    ],
    buttons: [['Identify the joint', '.identify']],
    command: 'stiction device --port DEV identify --into joint.toml',
    here: 'identified',
  },
  {
    title: 'Tune',
    picture: picture(
      '<path d="M40 100V16M40 100H290" class="ink"/><path d="M40 100C70 20 90 30 120 ' +
        '44S180 40 290 42" class="curve"/>' +
        '<path d="M40 100C60 -10 90 90 120 30S180 50 290 42" class="cloud"/><path ' +
        'd="M40 100C90 70 120 50 160 46S220 42 290 42" class="cloud"/><path d="M40 ' +
        '42H290" class="bound"/>',
    ),
    text: [
      'Gains are tuned on joints around one, and judged on others. This needs no ' +
        'device, moves ' +
        'nothing, and can take minutes. “Joint” selects that one: the joint of the file, or the ' +
        'identified joint of the step before.',
      'The view “What if” shows the effect of a gain, on either joint and on ' +
        'those around it. ' +
        'Better gains go into the form under “Parameters”, where “Set” sends them; the new file ' +
        'can be pushed there.',
    ],
    buttons: [
      ['What if', 'what-if'],
      ['Parameters', 'parameters'],
    ],
    command: 'stiction tune joint.toml --out tuned.toml',
    alone: true,
    here: 'tuning',
  },
  {
    title: 'Verify',
    picture: picture(
      '<path d="M40 100V16M40 100H290" class="ink"/><path d="M40 96C80 96 90 40 140 ' +
        '40H280" class="bound"/><path d="M40 96C84 96 96 36 146 40H280" class="curve"/>' +
        '<path d="M236 70l12 12 26-30" class="good"/>',
    ),
    text: [
      'Arm, move to both ends of the range, and look at the error under “Live”. ' +
        'Under “What if” the prediction is drawn over the last measured move: ' +
        'if the two differ, the joint differs from that of the file.',
      'The self-test makes twenty moves automatically, and compares them with a simulation of a ' +
        'file’s joint: that of the studio, or the identified one. It is predicted first; ' +
        'nothing moves. Then you start the moves. Stop, Escape, or closing this page ends it.',
    ],
    buttons: [
      ['Live', 'live'],
      ['What if', 'what-if'],
    ],
    command: 'stiction device --port DEV --machine tuned.toml selftest',
    here: 'selftest',
  },
  {
    title: 'Save',
    picture: picture(box(40, 43, 90, 'in use') + arrow('M130 60H186') + box(190, 43, 90, 'flash')),
    text: [
      'A reset discards the parameters in use. Save keeps them. Pull writes them to a ' +
        'file, which belongs to the machine’s documents.',
    ],
    buttons: [
      ['Save', '#save'],
      ['Pull', '#pull'],
    ],
    command: 'stiction device --port DEV params save',
  },
];

const isElsewhere = (then: string) => then.startsWith('#') || then.startsWith('.');

// Reason why a button of the page cannot be pressed now.
export function reason(then: string): string {
  const { connected, gone, recording, commands, status } = app;
  if (!connected) return 'there is no connection to the studio';
  if (then === '#pull') return 'the parameters are unknown, or cannot be written as a file';
  if (gone !== null) return 'the device does not answer';
  if (recording) return 'a recording is shown; “Back to the device” under “Session” closes it';
  if (!commands) return 'another page commands the device';
  if (status === null) return 'the state of the device is not known yet';
  if (status.driven) return 'the motor is driven; stop first';
  if (then === '#save' && status.unsaved === false) return 'the parameters in use are saved';
  if (status.gear) return 'moves measure the gear; stop ends them';
  if (status.state === 'faulted') return 'a fault is latched; clear it first';
  return 'the device is not ready';
}

export class Commissioning {
  private at = 0;
  // Buttons of this step that press another one.
  private pressed: [HTMLButtonElement, string][] = [];

  constructor(private readonly show: (view: string, search?: string) => void) {
    by('steps').replaceChildren(
      ...STEPS.map(({ title }, place) => {
        const button = element('button', { textContent: `${place + 1} ${title}` });
        button.onclick = () => this.go(place);
        return element('li', {}, button);
      }),
    );
    on('step-back', () => this.go(this.at - 1));
    on('step-on', () => this.go(this.at + 1));
    this.go(0);
  }

  private go(to: number): void {
    this.at = Math.min(STEPS.length - 1, Math.max(0, to));
    const { title, picture, text, inPage, buttons, command, alone, live, here } = STEPS[this.at];
    for (const one of HERE) by(one).hidden = one !== here;
    by('steps')
      .querySelectorAll('button')
      .forEach((one, place) =>
        one.setAttribute('aria-current', place === this.at ? 'step' : 'false'),
      );
    by('step-title').textContent = `${this.at + 1} ${title}`;
    by('step-picture').innerHTML = picture;
    const words = (IN_PAGE && inPage) || text;
    by('step-text').replaceChildren(...words.map((one) => element('p', { textContent: one })));
    by('step-live').hidden = !live;
    this.pressed = [];
    by('step-buttons').replaceChildren(
      ...(buttons ?? []).map(([label, then]) => {
        const button = element('button', { textContent: label });
        button.onclick = () => this.press(then);
        if (isElsewhere(then)) this.pressed.push([button, then]);
        return button;
      }),
    );
    this.look();
    by('step-command').hidden = !command;
    by('step-command-when').textContent = alone
      ? 'By the command line, without a device:'
      : 'By the command line, after ending the studio:';
    by('step-command-text').textContent = command ?? '';
    on('step-copy', () => void this.copy(command ?? ''));
    by<HTMLButtonElement>('step-back').disabled = this.at === 0;
    by<HTMLButtonElement>('step-on').disabled = this.at === STEPS.length - 1;
  }

  private press(then: string): void {
    if (then === 'limits') return this.show('parameters', 'limits');
    if (isElsewhere(then)) {
      document.querySelector<HTMLElement>(then)?.click();
      return;
    }
    this.show(then);
  }

  private async copy(text: string): Promise<void> {
    try {
      await navigator.clipboard.writeText(text);
      by('step-copy').textContent = 'Copied';
    } catch {
      // Without access to the clipboard the text is selected, so that Ctrl+C copies it.
      getSelection()?.selectAllChildren(by('step-command-text'));
      by('step-copy').textContent = 'Marked';
    }
    setTimeout(() => (by('step-copy').textContent = 'Copy'), 2000);
  }

  // Shows the position since power-on, which needs no loop, and the buttons that can be pressed.
  look(): void {
    const { status, hello } = app;
    const why = new Set<string>();
    for (const [button, then] of this.pressed) {
      button.disabled = document.querySelector(then)?.matches(':disabled') ?? true;
      if (button.disabled) why.add(`${button.textContent}: ${reason(then)}.`);
    }
    // A screen reader speaks it when it changes, not with each status.
    const text = [...why].join(' ');
    if (by('step-why').textContent !== text) by('step-why').textContent = text;
    const counts = status?.since_power_on_counts;
    by('step-live').textContent =
      counts === undefined || !hello
        ? 'Position: –'
        : `Position since power-on: ${counts} counts, ` +
          `${(counts * hello.resolution_deg).toFixed(4)} deg`;
  }
}
