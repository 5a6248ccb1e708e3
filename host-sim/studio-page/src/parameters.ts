// View of the parameters: set, undo, save, push, pull, and compare with a file.

import { app, by, element, may, on } from './app';
import { Form } from './form';
import { LARGEST, type Link } from './link';
import { ask, report } from './messages';
import { download, stamp } from './session';

let refusal = '';

// Reads a chosen file. A file that is too large is refused unread.
export function read(
  input: HTMLInputElement,
  then: (text: string, name: string) => void,
  most = Infinity,
): void {
  input.onchange = async () => {
    const chosen = input.files?.[0];
    input.value = '';
    if (!chosen) return;
    const { name, size } = chosen;
    if (size > most)
      return report(
        `${name}: the file has ${Math.ceil(size / 1024)} KiB; it must have at most ${most / 1024} KiB`,
        false,
      );
    then(await chosen.text(), name);
  };
}

export class Parameters {
  readonly form: Form;

  constructor(
    private readonly link: Link,
    private readonly look: () => void,
  ) {
    this.form = new Form(by('form'), () => {
      refusal = '';
      this.edited();
    });
    const { form } = this;
    by('search').oninput = by('only-changed').onchange = () =>
      form.find(by<HTMLInputElement>('search').value, by<HTMLInputElement>('only-changed').checked);
    on('discard', () => {
      refusal = '';
      form.edits.clear();
      form.update(form.rows);
      this.edited();
    });
    by('form').onsubmit = (event) => {
      event.preventDefault();
      void this.set(Object.fromEntries(form.edits));
    };
    for (const what of ['undo', 'save']) on(what, () => void ask(link, what));
    on('pull', () => {
      if (app.file)
        download(new Blob([app.file], { type: 'application/toml' }), `stiction-${stamp()}.toml`);
    });
    read(by('push'), (text) => void ask(link, 'push', { text }), LARGEST);
    read(by('compare'), (text, name) => void this.compare(text, name), LARGEST);
    on('compare-own', () => void this.compare('', ''));
    on('compare-not', () => this.compared(null, []));
  }

  // Sets all values or none; a refusal is shown at its value.
  async set(values: Record<string, string>): Promise<boolean> {
    const { form } = this;
    const answer = await this.link.ask('set', { values });
    report(answer.said, answer.ok);
    refusal = answer.ok ? '' : answer.said;
    if (answer.ok) {
      // Other typed values stay.
      for (const [path, value] of Object.entries(values))
        if (form.edits.get(path) === value) form.edits.delete(path);
      form.update(form.rows);
    }
    form.blame(refusal);
    this.edited();
    return answer.ok;
  }

  // Puts values into the form as if typed, and returns how many differ from those in use.
  put(values: Record<string, number>): number {
    const { form } = this;
    for (const { path, value } of form.rows) {
      if (!(path in values)) continue;
      if (Number(value) === values[path]) form.edits.delete(path);
      else form.edits.set(path, String(values[path]));
    }
    by<HTMLInputElement>('search').value = '';
    by<HTMLInputElement>('only-changed').checked = false;
    refusal = '';
    form.update(form.rows);
    form.find('', false);
    this.edited();
    return Object.keys(values).filter((path) => form.edits.has(path)).length;
  }

  private async compare(text: string, chosen: string): Promise<void> {
    const answer = await this.link.ask('compare', { text });
    if (!answer.ok) return report(answer.said, false);
    const { name, values, changes } = answer.said as any;
    this.compared({ name: chosen || name, values }, changes);
  }

  private compared(file: Form['compared'], changes: string[]): void {
    this.form.compared = file;
    this.form.update(this.form.rows);
    by('comparison').hidden = file === null;
    if (!file) return;
    const count = changes.length;
    by('comparison-what').textContent = count
      ? `${count} ${count === 1 ? 'value differs' : 'values differ'} from ` +
        `${file.name}. In use, and in the file:`
      : `Nothing differs from ${file.name}.`;
    by('comparison-list').replaceChildren(
      ...changes.map((line) => element('li', { textContent: line.replace(' -> ', ' → ') })),
    );
  }

  edited(): void {
    const count = this.form.edits.size;
    by('set').textContent = count ? `Set ${count} ${count === 1 ? 'value' : 'values'}` : 'Set';
    by<HTMLButtonElement>('discard').disabled = count === 0;
    this.look();
  }

  // Enables the possible actions.
  enable(driven: boolean | null): void {
    const { form } = this;
    const free = may() && driven === false;
    const set = (id: string, enabled: boolean) => {
      by<HTMLButtonElement>(id).disabled = !enabled;
    };
    form.enable(free);
    set('undo', free && Number(by('undo').dataset.left) > 0);
    set('save', free && app.status?.unsaved === true);
    set('pull', app.file !== null);
    set('set', free && form.edits.size > 0);
    by<HTMLInputElement>('push').disabled = !free;
    by('parameters-said').textContent = refusal
      ? `✕ Refused: ${refusal}`
      : app.recording
        ? 'A recording has no device to set.'
        : app.status === null
          ? 'The state of the device is not known yet.'
          : driven
            ? 'The motor is driven: stop first. Parameters change only while it is off.'
            : app.status?.unsaved
              ? 'Values in use are not saved: a reset discards them.'
              : '';
  }

  get law(): string {
    const tables = this.form.rows
      .map((row) => row.table)
      .filter((table) => table.startsWith('controller.'));
    return (
      tables[0]?.slice('controller.'.length) ??
      (app.hello?.law.length ? 'with signals of its own' : 'not known')
    );
  }
}
