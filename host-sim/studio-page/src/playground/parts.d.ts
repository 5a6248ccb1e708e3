// Modules that playground.mjs puts into the page.

declare module 'playground:simulator' {
  // WebAssembly, packed by gzip.
  const packed: Uint8Array;
  export default packed;
}
declare module 'playground:worker' {
  const script: string;
  export default script;
}
