import { MessageTree } from "../ui/MessageTree";
import classes from "./graph.module.css";

/** A message, to read; it scrolls, so that what is below stays where it is. */
export function MessageView({ message }: { message: unknown }) {
  return (
    // biome-ignore lint/a11y/noNoninteractiveTabindex: what scrolls has to be reachable by keyboard
    <section className={classes.message} tabIndex={0} aria-label="The message">
      <MessageTree value={message} label="Fields" open={2} />
    </section>
  );
}
