// List of the faults that the device remembers, with their remedies.

export type Fault = { code: number; said: string; section: string | null; ends: string | null };

export function remedy({ ends }: Fault): string {
  const then: Record<string, string> = {
    command: 'Fix the cause, then clear the fault.',
    parameters: 'It ends with valid parameters: set or push them, and save them.',
    reset: 'Fix the cause; it ends with a reset.',
  };
  return then[ends ?? ''] ?? 'This program is older than the firmware: remedy unknown.';
}

export function list(root: HTMLElement, faults: Fault[]): void {
  const items = [...faults].reverse().map((fault) => {
    const item = document.createElement('li');
    const link = Object.assign(document.createElement('a'), {
      href: 'faults.md',
      target: '_blank',
      rel: 'noopener',
      textContent: fault.section ? `docs/reference/faults.md, “${fault.section}”` : '',
    });
    item.append(
      Object.assign(document.createElement('strong'), { textContent: fault.said }),
      document.createElement('br'),
      `${remedy(fault)} `,
      link,
    );
    return item;
  });
  root.replaceChildren(...items);
  if (items.length === 0)
    root.append(
      Object.assign(document.createElement('li'), { textContent: 'no fault since power-on' }),
    );
}
