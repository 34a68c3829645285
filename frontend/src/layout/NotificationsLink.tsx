import { ActionIcon } from "@mantine/core";
import { Link } from "react-router";

/** A bell; on a phone the page is in the menu. */
export function NotificationsLink() {
  return (
    <ActionIcon
      component={Link}
      to="/ui/notifications"
      variant="default"
      size="lg"
      aria-label="Notifications"
      title="Notifications (g, then n)"
      visibleFrom="sm"
    >
      <svg width="20" height="20" viewBox="0 0 24 24" aria-hidden="true" fill="currentColor">
        <path d="M12 2a1.5 1.5 0 0 1 1.5 1.5v.7A6 6 0 0 1 18 10v5l2 2v1H4v-1l2-2v-5a6 6 0 0 1 4.5-5.8v-.7A1.5 1.5 0 0 1 12 2Zm0 4a4 4 0 0 0-4 4v6h8v-6a4 4 0 0 0-4-4Zm-2 13h4a2 2 0 0 1-4 0Z" />
      </svg>
    </ActionIcon>
  );
}
