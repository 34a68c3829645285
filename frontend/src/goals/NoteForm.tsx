import { Group, Text, Textarea, TextInput } from "@mantine/core";
import { type FormEvent, type KeyboardEvent, useState } from "react";
import { MAX_NAME, ownName, setOwnName } from "../access/who";
import { ReasonButton } from "../ui/ReasonButton";

/** As the gateway allows. */
const MAX_TEXT = 2000;

interface NoteFormProps {
  /** Why none can be added now; null where it can. */
  reason: string | null;
  onAdd: (by: string, text: string, done: () => void) => void;
}

/** Adds a note with the name that was given on this computer; asks for one where there is none. */
export function NoteForm({ reason, onAdd }: NoteFormProps) {
  const [text, setText] = useState("");
  const [known, setKnown] = useState(() => ownName().trim());
  const [name, setName] = useState("");
  const by = known || name.trim();
  const missing =
    reason ?? (text.trim() === "" ? "Write something first." : by === "" ? "Enter your name first." : null);
  const add = () => {
    if (missing !== null) return;
    if (known === "") setOwnName(by);
    setKnown(by);
    onAdd(by, text, () => setText(""));
  };
  const submit = (event: FormEvent) => {
    event.preventDefault();
    add();
  };
  const press = (event: KeyboardEvent) => {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) add();
  };
  return (
    <form onSubmit={submit}>
      <Textarea
        aria-label="New note"
        placeholder="What happened?"
        rows={2}
        resize="vertical"
        maxLength={MAX_TEXT}
        value={text}
        onChange={(event) => setText(event.currentTarget.value)}
        onKeyDown={press}
      />
      <Group gap="xs" mt="xs" justify="flex-end">
        {known === "" ? (
          <TextInput
            aria-label="Your name"
            placeholder="Your name"
            autoComplete="name"
            size="xs"
            maxLength={MAX_NAME}
            value={name}
            onChange={(event) => setName(event.currentTarget.value)}
          />
        ) : (
          <Text size="sm" c="dimmed">
            as {known}
          </Text>
        )}
        <ReasonButton type="submit" variant="default" size="xs" reason={missing}>
          Add note
        </ReasonButton>
      </Group>
    </form>
  );
}
