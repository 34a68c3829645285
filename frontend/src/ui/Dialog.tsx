import { CloseButton, Group, Modal, Title } from "@mantine/core";
import type { ReactNode } from "react";

interface DialogProps {
  title: string;
  opened: boolean;
  onClose: () => void;
  children: ReactNode;
}

/** A dialog below the header, so that Stop stays in reach. Its title is not a second header of the page. */
export function Dialog({ title, opened, onClose, children }: DialogProps) {
  return (
    <Modal.Root opened={opened} onClose={onClose} zIndex={250} yOffset="calc(var(--header-height) + 1rem)">
      <Modal.Overlay />
      {/* While it fades out, a second press would send its command again. */}
      <Modal.Content aria-label={title} inert={!opened}>
        <Modal.Body pt="md">
          <Group justify="space-between" mb="sm" wrap="nowrap">
            <Title order={2} size="h4">
              {title}
            </Title>
            <CloseButton aria-label="Close" onClick={onClose} />
          </Group>
          {children}
        </Modal.Body>
      </Modal.Content>
    </Modal.Root>
  );
}
