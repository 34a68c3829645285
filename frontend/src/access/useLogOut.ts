import { notifications } from "@mantine/notifications";
import { logOut, logOutEverywhere } from "../api/access";
import { toCommandError } from "../api/errors";
import { useFleet } from "../fleet/context";

/** Logs out here, or everywhere, and loads the page again: nothing that it knew stays in it. */
export function useLogOut(): (everywhere?: boolean) => void {
  const { http } = useFleet();
  return (everywhere = false) =>
    void (everywhere ? logOutEverywhere(http) : logOut(http)).then(
      () => window.location.reload(),
      (error: unknown) => {
        const { title, detail } = toCommandError(error);
        notifications.show({ color: "red", title: `You are still logged in: ${title}`, message: detail });
      },
    );
}
