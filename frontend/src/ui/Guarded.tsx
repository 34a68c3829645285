import { Alert, Button, Stack, Text } from "@mantine/core";
import type { ReactNode } from "react";
import { ErrorBoundary } from "react-error-boundary";

interface GuardedProps {
  /** What is shown again when this changes. */
  of: string;
  /** Begins the sentence about what cannot be shown; null to say nothing. */
  what?: string | null;
  children: ReactNode;
}

/** A part of the page that takes nothing else with it if it cannot be shown. */
export function Guarded({ of, what = "This page", children }: GuardedProps) {
  return (
    <ErrorBoundary resetKeys={[of]} fallback={what === null ? null : <Problem what={what} />}>
      {children}
    </ErrorBoundary>
  );
}

function Problem({ what }: { what: string }) {
  return (
    <Alert color="orange" title={`${what} cannot be shown`}>
      <Stack gap="sm" align="flex-start">
        <Text size="sm">The gateway may have been updated since the page was loaded. Stop still works.</Text>
        <Button variant="default" onClick={() => window.location.reload()}>
          Load it again
        </Button>
      </Stack>
    </Alert>
  );
}
