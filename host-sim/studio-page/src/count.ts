// A number of things in words.

export const count = (number: number, one: string, more = `${one}s`) =>
  `${number} ${number === 1 ? one : more}`;
