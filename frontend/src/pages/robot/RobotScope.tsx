import { type ReactNode, useEffect, useState } from "react";
import { useFleet } from "../../fleet/context";
import { type Services, ServicesProvider } from "../../store/context";

/** Gives what is inside one robot: its commands and what is known of it, read along while this is shown. */
export function RobotScope({ robot, children }: { robot: string | null; children: ReactNode }) {
  const { openRobot } = useFleet();
  const [services, setServices] = useState<Services | null>(null);

  useEffect(() => {
    const opened = openRobot(robot);
    setServices(opened.services);
    return () => {
      opened.close();
      setServices(null);
    };
  }, [openRobot, robot]);

  return services === null ? null : <ServicesProvider value={services}>{children}</ServicesProvider>;
}
