import { Button, Group, VisuallyHidden } from "@mantine/core";
import type { ExportFormat } from "../api/goals";

interface DownloadsProps {
  /** What is downloaded, to a screen reader. */
  what: string;
  url: (format: ExportFormat) => string;
}

const FORMATS: readonly ExportFormat[] = ["csv", "json"];

/** A link for each format that something can be had in. */
export function Downloads({ what, url }: DownloadsProps) {
  return (
    <Group gap="xs">
      {FORMATS.map((format) => (
        <Button key={format} component="a" href={url(format)} download variant="default" size="compact-sm">
          Export {format.toUpperCase()}
          <VisuallyHidden> of {what}</VisuallyHidden>
        </Button>
      ))}
    </Group>
  );
}
