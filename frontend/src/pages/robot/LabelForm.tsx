import { Skeleton, Stack, TagsInput, TextInput } from "@mantine/core";
import { type FormEvent, useEffect, useRef, useState } from "react";
import { getLabel, type Label, putLabel } from "../../api/client";
import { toClientError } from "../../api/errors";
import { LIMITS } from "../../api/limits.gen";
import { useFleet, useNaming } from "../../fleet/context";
import { namespaceWords } from "../../fleet/names";
import { Conflict, isConflict } from "../../ui/Conflict";
import { SaveBar } from "../../ui/Dialog";
import { Trouble } from "../../ui/errors";
import { useAnswer, useCommand } from "../../ui/requests";

const { display_name: NAME, groups: GROUPS } = LIMITS["PUT /label"];

/** The display name and the groups of a robot, for everybody. */
export default function LabelForm({ robot, onDone }: { robot: string; onDone: () => void }) {
  const { http } = useFleet();
  const { data, error, refetch } = useAnswer({
    queryKey: ["label", robot],
    queryFn: () => getLabel(http, robot),
    gcTime: 0, // a form that is opened again begins with the label as it is then
  });
  if (data !== undefined) return <Fields label={data} onConflict={refetch} onDone={onDone} />;
  if (error === null) return <Skeleton height={180} />;
  return <Trouble what="The name could not be loaded" error={error} onRetry={() => void refetch()} />;
}

interface FieldsProps {
  /** The label as it is now. */
  label: Label;
  /** Asks for the label again: someone else has changed it. */
  onConflict: () => Promise<unknown>;
  onDone: () => void;
}

function Fields({ label, onConflict, onDone }: FieldsProps) {
  const { http } = useFleet();
  const naming = useNaming();
  const { robot } = label;
  /** What the fields are based on. */
  const [base, setBase] = useState(label);
  const [name, setName] = useState(label.display_name ?? "");
  const [groups, setGroups] = useState(label.groups);
  // It is loaded on demand: the dialog has looked for what gets the focus before it came.
  const first = useRef<HTMLInputElement>(null);
  useEffect(() => first.current?.focus(), []);
  const save = useCommand(async (replaced: Label) => {
    try {
      return await putLabel(http, replaced, { display_name: name.trim() || null, groups });
    } catch (error) {
      if (isConflict(toClientError(error))) await onConflict();
      throw error;
    }
  });
  const store = (replaced: Label) => save.mutate(replaced, { onSuccess: onDone });
  const submit = (event: FormEvent) => {
    event.preventDefault();
    store(base);
  };
  const show = (newest: Label) => {
    setBase(newest);
    setName(newest.display_name ?? "");
    setGroups(newest.groups);
    save.reset();
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
        <SaveBar
          save={save}
          onCancel={onDone}
          trouble={
            isConflict(save.error) && <Conflict newest={label} onShow={show} onReplace={() => store(label)} />
          }
        />
      </Stack>
    </form>
  );
}
