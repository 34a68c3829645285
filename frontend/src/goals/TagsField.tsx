import { TagsInput } from "@mantine/core";
import { useTags } from "./useTags";

/** As the gateway allows. */
const MAX_TAGS = 10;
const MAX_TAG = 30;

interface TagsFieldProps {
  tags: readonly string[];
  /** Why they cannot be changed now; null where they can. */
  reason: string | null;
  onTags: (tags: string[]) => void;
}

/** The tags of a goal, saved as they are added and removed. */
export function TagsField({ tags, reason, onTags }: TagsFieldProps) {
  const known = useTags();
  return (
    <TagsInput
      aria-label="Tags"
      placeholder={tags.length < MAX_TAGS ? "Add a tag" : ""}
      data={[...known]}
      maxTags={MAX_TAGS}
      maxLength={MAX_TAG}
      value={[...tags]}
      onChange={(next) => reason === null && onTags(next)}
      readOnly={reason !== null}
      title={reason ?? undefined}
      comboboxProps={{ withinPortal: false }}
      acceptValueOnBlur
    />
  );
}
