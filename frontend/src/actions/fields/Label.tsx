import { VisuallyHidden } from "@mantine/core";

/** A field's name, as ROS has it, and its unit for those who do not see it at the end of the input. */
export function Label({ name, unit }: { name: string; unit: string | null }) {
  return (
    <>
      {name}
      {unit !== null && <VisuallyHidden> in {unit}</VisuallyHidden>}
    </>
  );
}
