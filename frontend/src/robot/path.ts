/** Where a robot's page is. */
export function robotPath(robot: string): string {
  return `/ui/robot?robot=${encodeURIComponent(robot).replaceAll("%2F", "/")}`;
}
