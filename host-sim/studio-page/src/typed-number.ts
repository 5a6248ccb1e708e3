// Numbers that a person types, with the rules of typed_number.rs, which terminal and command line
// use; typed_number_cases.json tests both.

export type Typed = { value: number; refused: null } | { value: null; refused: string };

export function parse(text: string): Typed {
  const typed = text.trim();
  const plain = typed.replaceAll('−', '-');
  const refuse = (refused: string): Typed => ({ value: null, refused });
  if (typed === '') return refuse('nothing was typed; type a number such as -2.5');
  const withPoint = plain.replaceAll(',', '.');
  const value = /^[0-9+\-.,eE]+$/.test(plain) ? Number(withPoint) : NaN;
  if (Number.isNaN(value)) return refuse(`\`${typed}\` is not a number; type one such as -2.5`);
  // `1,234` is 1.234 in one country and 1234 in another.
  const [whole, rest] = plain.split(',');
  if (rest !== undefined && rest.search(/[eE]|$/) === 3) {
    // No thousands begin with a zero.
    const other = /^[+-]*0*$/.test(whole) ? '' : ` or ${whole}${rest}`;
    return refuse(`\`${typed}\` is ambiguous: type ${withPoint}${other}, without a comma`);
  }
  if (!Number.isFinite(value))
    return refuse(`\`${typed}\` is too large; type a number below 1.8e308`);
  return { value, refused: null };
}

// Returns the number that a text is read as if it is written differently, or why it is refused;
// nothing for a text that does not start like a number.
export function reading(text: string): string {
  const { value, refused } = parse(text);
  if (refused !== null) return /^[\s\d+\-−.,]/.test(text) ? `✕ ${refused}` : '';
  return String(value) === text.trim() ? '' : `read as ${value}`;
}
