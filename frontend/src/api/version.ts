/** What a change is based on: a thing as it was read, or null for a new one. */
export type Base = { readonly etag: string } | null;

/** The headers with which the gateway refuses a change (`changed_meanwhile`) where someone else was faster. */
export function ifUnchanged(base: Base): { "If-Match"?: string; "If-None-Match"?: string } {
  return base === null ? { "If-None-Match": "*" } : { "If-Match": base.etag };
}
