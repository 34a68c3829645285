import { ActionIcon, Group } from "@mantine/core";

interface PictureButtonsProps {
  onIn: () => void;
  onOut: () => void;
  onFit: () => void;
  onRearrange: () => void;
}

const ICONS = {
  in: "M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6z",
  out: "M5 11h14v2H5z",
  fit: "M4 4h6v2H6v4H4zm10 0h6v6h-2V6h-4zM4 14h2v4h4v2H4zm14 0h2v6h-6v-2h4z",
  rearrange: "M3 4h6v5H7v2h10V9h-2V4h6v5h-2v4h-6v2h2v5H9v-5h2v-2H5V9H3z",
} as const;

/** What the mouse can do with the picture but by wheel and drag. */
export function PictureButtons({ onIn, onOut, onFit, onRearrange }: PictureButtonsProps) {
  return (
    <Group gap={4}>
      <PictureButton label="Closer (+)" icon="in" onClick={onIn} />
      <PictureButton label="Farther (−)" icon="out" onClick={onOut} />
      <PictureButton label="All of it (0)" icon="fit" onClick={onFit} />
      <PictureButton label="Re-arrange" icon="rearrange" onClick={onRearrange} />
    </Group>
  );
}

interface PictureButtonProps {
  label: string;
  icon: keyof typeof ICONS;
  onClick: () => void;
}

function PictureButton({ label, icon, onClick }: PictureButtonProps) {
  return (
    <ActionIcon variant="default" size="lg" aria-label={label} title={label} onClick={onClick}>
      <svg width="18" height="18" viewBox="0 0 24 24" aria-hidden="true" fill="currentColor">
        <path d={ICONS[icon]} />
      </svg>
    </ActionIcon>
  );
}
