import { Button, Menu } from "@mantine/core";
import type { ColumnChoice } from "./columns";

/** Chooses the columns of the table. */
export function ColumnsMenu({ choice: { shown, optional, toggle } }: { choice: ColumnChoice }) {
  return (
    <Menu closeOnItemClick={false} position="bottom-end" withInitialFocusPlaceholder={false}>
      <Menu.Target>
        <Button variant="subtle" size="compact-sm" color="gray">
          Columns
        </Button>
      </Menu.Target>
      <Menu.Dropdown>
        {optional.map(({ sort, name }, index) => (
          <Menu.CheckboxItem
            key={sort}
            checked={shown.has(sort)}
            onChange={() => toggle(sort)}
            data-autofocus={index === 0 || undefined}
          >
            {name}
          </Menu.CheckboxItem>
        ))}
      </Menu.Dropdown>
    </Menu>
  );
}
