/** The severities of alerts that cause a notification. */
export const SEVERITY_OPTIONS = [
  { value: "all", label: "All alerts" },
  { value: "critical", label: "Critical alerts only" },
];
