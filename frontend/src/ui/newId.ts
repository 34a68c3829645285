/** As the gateway allows. */
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
