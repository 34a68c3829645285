import { goalsPath } from "../api/actions";

/** The command line that sends a goal, for any POSIX shell. */
export function sendLine(origin: string, action: string, body: string): string {
  return `curl -sX POST ${origin}${goalsPath(action)} -H 'Content-Type: application/json' -d ${quoted(body)}`;
}

/** A word of a shell that stands for this text, whatever is in it. */
export function quoted(text: string): string {
  return `'${text.replaceAll("'", "'\\''")}'`;
}
