// Keyboard. Escape stops at any focus; Space stops outside of text fields. So Enter replaces Space
// elsewhere: it presses buttons, toggles boxes and opens files. A list takes letters and arrows,
// not Space: the arrows open it, too.

export function listen(stop: () => void, keys: Record<string, () => void>): void {
  const takesBlanks = (target: HTMLElement) =>
    target.matches('input:not([type=checkbox]):not([type=file]):not([type=range]), textarea');
  const takesKeys = (target: HTMLElement) =>
    takesBlanks(target) || target.matches('[type=range], select');
  document.addEventListener(
    'keydown',
    (event) => {
      const target = event.target as HTMLElement;
      if (event.key === 'Escape' || (event.key === ' ' && !takesBlanks(target))) {
        event.preventDefault();
        stop();
        return;
      }
      if (event.key === 'Enter' && target.matches('[type=checkbox], [type=file]')) {
        event.preventDefault();
        target.click();
        return;
      }
      // Caps Lock makes capital letters. Keys with Shift are not used.
      const isShifted = event.shiftKey && !event.getModifierState('CapsLock');
      const then = keys[event.key] ?? (isShifted ? undefined : keys[event.key.toLowerCase()]);
      if (takesKeys(target) || event.ctrlKey || event.altKey || event.metaKey || !then) return;
      event.preventDefault();
      then();
    },
    true,
  );
  // The release of Space would press a focused button; it only stops.
  document.addEventListener(
    'keyup',
    (event) => {
      if (event.key === ' ' && !takesBlanks(event.target as HTMLElement)) event.preventDefault();
    },
    true,
  );
}
