/** The gateway's and the action server's words as a sentence of this page: begins with a capital. */
export function sentence(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** The other way round, for a place in the middle of a sentence. */
export function lowerFirst(text: string): string {
  return text.charAt(0).toLowerCase() + text.slice(1);
}

/** The longest id that the gateway allows. */
const MAX_ID = 40;

/** An id for something new: its name in small letters and digits, and a number where that is taken. */
export function newId(name: string, taken: readonly string[], noun: string): string {
  const plain = name
    .normalize("NFKD")
    .replace(/\p{M}/gu, "")
    .toLowerCase()
    .replace(/[^a-z0-9]+/g, "-");
  const slug = plain.slice(0, MAX_ID - 4).replace(/^-+|-+$/g, "") || noun;
  let id = slug;
  for (let number = 2; taken.includes(id); number++) id = `${slug}-${number}`;
  return id;
}
