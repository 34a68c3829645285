import { Text } from "@mantine/core";
import { type ReactNode, useEffect, useState } from "react";
import { isArray, isObject, type Json } from "../../api/jsonSchema";
import { errorsIn } from "../form/draft";
import { dotted, type Path } from "../form/values";
import { useForm } from "./context";
import classes from "./fields.module.css";

interface FoldProps {
  path: Path;
  label: string;
  /** The message's type. */
  type: string;
  description: string | null;
  /** What of it is sent. */
  sent: Json | undefined;
  alone: boolean;
  /** Made when it is unfolded. */
  children: () => ReactNode;
}

/** A message inside of another: folded, but where something is set in it, or there is nothing else to fill in. */
export function Fold({ path, label, type, description, sent, alone, children }: FoldProps) {
  const { errors, sought } = useForm();
  const where = dotted(path);
  const wrong = errorsIn(errors, where).length;
  const set = countSet(sent);
  const [open, setOpen] = useState(alone || set > 0);
  const isSought = sought?.startsWith(`${where}.`) === true;

  useEffect(() => {
    if (isSought) setOpen(true);
  }, [isSought]);

  return (
    <details className={classes.fold} open={open} onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>
        <span className={classes.name}>{label}</span> <span className={classes.type}>{shortType(type)}</span>
        {set > 0 && <span className={classes.set}>{set} set</span>}
        {wrong > 0 && <span className={classes.wrong}>{wrong} not valid</span>}
      </summary>
      {open && (
        <div className={classes.folded}>
          {description !== null && (
            <Text size="sm" c="dimmed" className={classes.description}>
              {description}
            </Text>
          )}
          {children()}
        </div>
      )}
    </details>
  );
}

/** How many fields of a message are set. */
function countSet(json: Json | undefined): number {
  if (json === undefined) return 0;
  if (isObject(json)) return Object.values(json).reduce<number>((sum, each) => sum + countSet(each), 0);
  return isArray(json) && json.some(isObject)
    ? Math.max(
        1,
        json.reduce<number>((sum, each) => sum + countSet(each), 0),
      )
    : 1;
}

/** As `ros2` prints types: without the `msg` in the middle. */
function shortType(type: string): string {
  return type.replace("/msg/", "/");
}
