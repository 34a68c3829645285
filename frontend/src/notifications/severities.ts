/** Which alerts are told of. */
export const SEVERITY_OPTIONS = [
  { value: "all", label: "All alerts" },
  { value: "critical", label: "Critical alerts only" },
];
