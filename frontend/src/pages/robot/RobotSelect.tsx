import { Select } from "@mantine/core";
import { useState } from "react";
import { useNavigate, useSearchParams } from "react-router";
import { useNaming } from "../../fleet/context";
import { readTab, robotPath } from "../../fleet/names";

/** Goes to the robot that is chosen, on the same tab. */
export default function RobotSelect({ others }: { others: readonly string[] }) {
  const naming = useNaming();
  const navigate = useNavigate();
  const [query] = useSearchParams();
  const [text, setText] = useState("");
  return (
    <Select
      aria-label="Switch robot"
      placeholder="Switch robot"
      data={others.map((name) => ({ value: name, label: naming.fullNameOf(name) }))}
      value={null}
      searchable
      searchValue={text}
      onSearchChange={setText}
      nothingFoundMessage="No such robot"
      // The first match is highlighted as soon as there is a list, and stays so: without these, Mantine forgets it after opening.
      selectFirstOptionOnChange
      selectFirstOptionOnDropdownOpen
      comboboxProps={{ transitionProps: { duration: 0 } }}
      onChange={(name) => {
        setText("");
        if (name !== null) navigate(robotPath(name, readTab(query)));
      }}
    />
  );
}
