import { MantineProvider } from "@mantine/core";
import { fireEvent, render, screen } from "@testing-library/react";
import { useState } from "react";
import { expect, it, vi } from "vitest";
import { Dialog } from "../src/ui/Dialog";

it("takes no second press while it fades out", async () => {
  // Unlike elsewhere in the tests, there are animations.
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener() {}, removeEventListener() {} }));
  function Page() {
    const [opened, setOpened] = useState(true);
    return (
      <MantineProvider>
        <Dialog title="Sure?" opened={opened} onClose={() => setOpened(false)}>
          <button type="button" onClick={() => setOpened(false)}>
            Go
          </button>
        </Dialog>
      </MantineProvider>
    );
  }
  render(<Page />);
  const go = await screen.findByText("Go");
  fireEvent.click(go);
  expect(go.isConnected).toBe(true); // it fades out
  expect(go.closest("[inert]")).not.toBeNull();
});
