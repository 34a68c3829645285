import { NativeSelect, type NativeSelectProps } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { listTags } from "../api/goals";
import { ofSites } from "../api/places";
import { useFleet } from "../fleet/context";

interface TagSelectProps extends Pick<NativeSelectProps, "label" | "aria-label"> {
  /** What no tag chosen is called. */
  any: string;
  chosen: readonly string[];
  onTags: (tags: string[]) => void;
}

/** Between several tags, as no tag can have it. */
const SEVERAL = "\n";

/** Chooses a tag of goals; nothing where no goal has one. An address may have chosen several. */
export function TagSelect({ any, chosen, onTags, ...props }: TagSelectProps) {
  const tags = [...new Set([...useTags(), ...chosen])].sort();
  if (tags.length === 0) return null;
  const several = { value: chosen.join(SEVERAL), label: chosen.join(" or ") };
  return (
    <NativeSelect
      {...props}
      value={chosen.join(SEVERAL)}
      onChange={(event) => onTags(event.currentTarget.value.split(SEVERAL).filter(Boolean))}
      data={[{ value: "", label: any }, ...(chosen.length > 1 ? [several] : []), ...tags]}
    />
  );
}

export const TAGS_KEY = ["tags"] as const;

/** The tags that goals have; none while they are not known. */
export function useTags(): readonly string[] {
  const { http } = useFleet();
  const { data } = useQuery({ queryKey: TAGS_KEY, queryFn: () => listTags(http), enabled: !ofSites() });
  return data ?? [];
}
