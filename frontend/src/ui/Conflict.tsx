import type { ClientError } from "@dock-gateway/client";
import { Alert, Button, Group, Text } from "@mantine/core";

interface ConflictProps<Entry> {
  /** The entry as it is now; undefined where it was removed. */
  newest: Entry | undefined;
  /** Shows it in the form, in place of what was typed. */
  onShow: (newest: Entry) => void;
  /** Saves what was typed all the same, in its place. */
  onReplace: (newest: Entry | null) => void;
}

/** Whether someone else has changed what a form changes. */
export function isConflict(error: ClientError | null): boolean {
  return error?.code === "changed_meanwhile";
}

/** Says that someone else has changed what a form changes, and how to go on: for an error that `isConflict`. */
export function Conflict<Entry extends object>(props: ConflictProps<Entry>) {
  const { newest, onShow, onReplace } = props;
  const by = newest !== undefined && "changed_by" in newest ? newest.changed_by : null;
  return (
    <Alert
      color="orange"
      role="alert"
      title={
        newest === undefined
          ? "Someone else has removed it"
          : `${by ?? "Someone else"} has changed it meanwhile`
      }
    >
      <Text size="sm">Your changes are not saved.</Text>
      <Group gap="sm" mt="xs">
        {newest !== undefined && (
          <Button variant="default" size="compact-sm" onClick={() => onShow(newest)}>
            Show the new version
          </Button>
        )}
        <Button variant="default" size="compact-sm" onClick={() => onReplace(newest ?? null)}>
          {newest === undefined ? "Save it as a new one" : "Replace it with mine"}
        </Button>
      </Group>
    </Alert>
  );
}
