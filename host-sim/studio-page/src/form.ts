// Form of the parameters. The server sends names, meanings and ranges from the core's declarations;
// the device validates the values.

import { reading } from './typed-number';

export type Row = {
  path: string;
  table: string;
  name: string;
  value: string;
  saved: string | null;
  allowed: string;
  otherwise: string;
  text: string;
};

export class Form {
  rows: Row[] = [];
  edits = new Map<string, string>();
  enabled = false;
  // A machine's file that the values are compared with.
  compared: { name: string; values: Record<string, string> } | null = null;

  constructor(
    private readonly root: HTMLElement,
    private readonly edited: () => void,
  ) {}

  update(rows: Row[]): void {
    this.rows = rows;
    // A value that the device has now is no edit any more.
    for (const row of rows) if (this.edits.get(row.path) === row.value) this.edits.delete(row.path);
    this.build();
  }

  private wanted = { words: '', changedOnly: false };

  // Focus, selection and open tables stay when the form is built anew.
  private build(): void {
    const at = document.activeElement;
    const path = this.root.contains(at) && at?.closest<HTMLElement>('[data-path]')?.dataset.path;
    const { selectionStart = null, selectionEnd = null } = at instanceof HTMLInputElement ? at : {};
    const open = new Set(
      [...this.root.querySelectorAll<HTMLDetailsElement>('details[open]')].map(
        (one) => one.dataset.table,
      ),
    );
    const first = this.root.childElementCount === 0;
    const tables = new Map<string, Row[]>();
    for (const row of this.rows) tables.set(row.table, [...(tables.get(row.table) ?? []), row]);
    this.root.replaceChildren(
      ...[...tables].map(([table, rows]) => {
        const group = document.createElement('details');
        group.dataset.table = table;
        group.open = first ? isOpen(table) : open.has(table);
        const summary = document.createElement('summary');
        summary.innerHTML = `<code></code> <small></small>`;
        summary.querySelector('code')!.textContent = `[${table}]`;
        group.append(summary, ...rows.map((row) => this.row(row)));
        return group;
      }),
    );
    this.mark();
    if (this.isFiltered) this.filter();
    if (!path) return;
    const input = this.box(path)?.querySelector('input');
    input?.focus({ preventScroll: true });
    input?.setSelectionRange(selectionStart, selectionEnd);
  }

  private box(path: string): HTMLElement | null {
    return this.root.querySelector<HTMLElement>(`[data-path="${CSS.escape(path)}"]`);
  }

  private row(row: Row): HTMLElement {
    const box = document.createElement('div');
    box.className = 'parameter';
    box.dataset.path = row.path;
    box.innerHTML =
      `<label><code></code></label><div class="value"><input autocomplete="off" ` +
      `spellcheck="false"><span class="marks"></span></div><div ` +
      `class="about"><p></p><small></small></div>`;
    const input = box.querySelector('input')!;
    const label = box.querySelector('label')!;
    input.id = `p-${row.path}`;
    label.htmlFor = input.id;
    label.querySelector('code')!.textContent = row.name;
    box.querySelector('p')!.append(...withCode(row.text));
    box
      .querySelector('small')!
      .append(...withCode(`Allowed: ${row.allowed}. Default in a file: ${row.otherwise}.`));
    input.value = this.edits.get(row.path) ?? row.value;
    input.disabled = !this.enabled;
    input.oninput = () => {
      if (input.value === row.value) this.edits.delete(row.path);
      else this.edits.set(row.path, input.value);
      this.mark();
      this.edited();
    };
    return box;
  }

  private mark(): void {
    for (const row of this.rows) {
      const box = this.box(row.path);
      if (!box) continue;
      const edit = this.edits.get(row.path);
      const unsaved = row.saved !== null && row.saved !== row.value;
      box.classList.toggle('edited', edit !== undefined);
      box.classList.toggle('unsaved', unsaved);
      const marks = [];
      if (edit !== undefined) {
        const read = reading(edit);
        marks.push(`✎ not set yet${read ? `, ${read}` : ''}; in use is ${row.value}`);
      }
      if (unsaved) marks.push(`◆ in use, not saved; saved is ${row.saved}`);
      const there = this.compared?.values[row.path];
      const differs = there !== undefined && there !== row.value;
      box.classList.toggle('differs', differs);
      if (differs) marks.push(`⇄ ${this.compared!.name} has ${there}`);
      box.querySelector('.marks')!.textContent = marks.join(' · ');
    }
    for (const group of this.root.querySelectorAll<HTMLElement>('details')) {
      const changed = group.querySelectorAll('.edited, .unsaved, .differs').length;
      group.querySelector('summary small')!.textContent = changed ? `${changed} changed` : '';
    }
  }

  enable(enabled: boolean): void {
    if (this.enabled === enabled) return;
    this.enabled = enabled;
    for (const input of this.root.querySelectorAll('input')) input.disabled = !enabled;
  }

  find(words: string, changedOnly: boolean): void {
    this.wanted = { words, changedOnly };
    this.filter();
  }

  private get isFiltered(): boolean {
    return this.wanted.words.trim() !== '' || this.wanted.changedOnly;
  }

  private filter(): void {
    const { words, changedOnly } = this.wanted;
    const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
    for (const group of this.root.querySelectorAll<HTMLDetailsElement>('details')) {
      let found = 0;
      for (const box of group.querySelectorAll<HTMLElement>('.parameter')) {
        const text = `${box.dataset.path} ${box.textContent}`.toLowerCase();
        const fits = wanted.every((word) => text.includes(word));
        const changed = box.matches('.edited, .unsaved, .differs');
        box.hidden = !fits || (changedOnly && !changed);
        if (!box.hidden) found++;
      }
      group.hidden = found === 0;
      group.open = this.isFiltered ? found > 0 : isOpen(group.dataset.table!);
    }
  }

  // Shows a refusal at the value that it names.
  blame(said: string): void {
    for (const box of this.root.querySelectorAll<HTMLElement>('.parameter')) {
      box.classList.toggle('refused', said.includes(box.dataset.path!));
    }
    const first = this.root.querySelector<HTMLElement>('.refused');
    first?.closest('details')?.setAttribute('open', '');
    first?.querySelector('input')?.focus();
  }
}

// Returns whether a table is open without a search.
function isOpen(table: string): boolean {
  return table.startsWith('controller') || table === 'limits';
}

// Text with names between backticks.
function withCode(text: string): (string | HTMLElement)[] {
  return text
    .split('`')
    .map((part, i) =>
      i % 2 ? Object.assign(document.createElement('code'), { textContent: part }) : part,
    );
}
