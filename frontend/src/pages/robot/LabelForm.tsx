import { Stack, TagsInput, TextInput } from "@mantine/core";
import { type FormEvent, useEffect, useRef, useState } from "react";
import { putLabel } from "../../api/client";
import { LIMITS } from "../../api/limits.gen";
import { useFleet, useNaming } from "../../fleet/context";
import { namespaceWords } from "../../fleet/names";
import { SaveBar } from "../../ui/Dialog";
import { useCommand } from "../../ui/requests";

const { display_name: NAME, groups: GROUPS } = LIMITS["PUT /label"];

/** The display name and the groups of a robot, for everybody. */
export default function LabelForm({ robot, onDone }: { robot: string; onDone: () => void }) {
  const { http } = useFleet();
  const naming = useNaming();
  const [name, setName] = useState(naming.displayNameOf(robot) ?? "");
  const [groups, setGroups] = useState([...naming.groupsOf(robot)]);
  // It is loaded on demand: the dialog has looked for what gets the focus before it came.
  const first = useRef<HTMLInputElement>(null);
  useEffect(() => first.current?.focus(), []);
  const save = useCommand(() => putLabel(http, robot, { display_name: name.trim() || null, groups }));
  const submit = (event: FormEvent) => {
    event.preventDefault();
    save.mutate(undefined, { onSuccess: onDone });
  };
  return (
    <form onSubmit={submit}>
      <Stack gap="md">
        <TextInput
          ref={first}
          label="Name"
          description={`Shown instead of ${robot} on every page, for everybody.`}
          placeholder={namespaceWords(robot)}
          maxLength={NAME.maxLength}
          value={name}
          onChange={(event) => setName(event.currentTarget.value)}
        />
        <TagsInput
          label="Groups"
          description="Enter adds one."
          data={naming.groups()}
          maxTags={GROUPS.maxItems}
          value={groups}
          onChange={setGroups}
          acceptValueOnBlur
        />
        <SaveBar save={save} onCancel={onDone} />
      </Stack>
    </form>
  );
}
