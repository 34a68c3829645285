import { Badge, createTheme, SegmentedControl, Tooltip } from "@mantine/core";

/** Mantine's defaults miss WCAG's contrast in places; these do not. */
export const theme = createTheme({
  primaryColor: "blue",
  primaryShade: 9,
  autoContrast: true,
  respectReducedMotion: true,
  cursorType: "pointer",
  fontFamily: "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'DejaVu Sans', sans-serif",
  fontFamilyMonospace: "ui-monospace, 'SF Mono', Menlo, Consolas, 'DejaVu Sans Mono', monospace",
  components: {
    Badge: Badge.extend({ defaultProps: { size: "lg", tt: "none", fw: 600 } }),
    SegmentedControl: SegmentedControl.extend({ defaultProps: { size: "sm" } }),
    Tooltip: Tooltip.extend({ defaultProps: { events: { hover: true, focus: true, touch: true } } }),
  },
});
