"""Compiles the kernels for GPUs, without a GPU, and holds what they take to a budget.

The texts are those of the program. Compilers come by package manager (scripts/fetched.py). Each
kernel's registers, spills, stack, local memory and occupancy are printed beside its budget. A
kernel that takes more, or one without a budget, is an error. `--renew` writes the budget.
"""

import argparse
import csv
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import fetched

BUDGET = fetched.ROOT / "crates/populace-opencl/gpu-budget.csv"
FIELDS = ["target", "kernel", "registers", "spilled_bytes", "stack_bytes", "local_bytes", "occupancy"]
# Options of crates/populace-opencl/src/device.rs, for devices that round division correctly.
OPTIONS = "-x cl -cl-std=CL1.2 -w -O3 -cl-fp32-correctly-rounded-divide-sqrt"
CLANG = ["clang-19", "libclang-common-19-dev", "libclc-19"]
PTXAS = ["nvidia-cuda-nvcc-cu12==12.9.86"]
NVIDIA, AMD = ["sm_90"], ["gfx1100", "gfx942"]

# The shape of a launch, for occupancies: groups of the staged and of the fused schedule, as in
# crates/populace-opencl/src/staged.rs, and bodies of 64 joints. Each of eight members of a fused
# group takes three rows of 16 bytes for each joint and three more, 16 elements of 16 bytes for what
# it plays, and 48 for rotations of its steps unless it is plain
# (crates/populace-opencl/src/fused/dispatch.rs).
GROUP, FUSED_GROUP, BATCH = 64, 128, 8
PLAIN_BYTES, STEP_BYTES = 16 * (3 * (64 + 3) + 16), 16 * 48


def shape_of(kernel):
    """Work-items of a kernel's groups, and bytes of local memory that the host adds."""
    if not kernel.startswith("fused_grouped"):
        return GROUP, 0
    members = 1 if kernel.endswith("joints") else BATCH
    return FUSED_GROUP, members * (PLAIN_BYTES + (0 if kernel.endswith("plain") else STEP_BYTES))


def warps_of_sm_90(registers, local_bytes, group):
    """Share of a multiprocessor's 64 warps that fit: 65,536 registers, taken in units of 256 for a
    warp; 228 KiB of local memory, of which each group takes 1 KiB more; 32 groups."""
    warps = group // 32
    by_registers = 65536 // (-(-registers * 32 // 256) * 256) // warps
    by_local = 228 * 1024 // (local_bytes + 1024)
    return min(by_registers, by_local, 32) * warps / 64


def waves(target, registers, local_bytes, group):
    """Share of a SIMD's waves that fit. gfx1100: 1,536 registers for each of 32 lanes in units of
    24, 16 waves, and 128 KiB of local memory for four SIMDs. gfx942: 512 in units of 8, 8 waves of
    64 lanes, 64 KiB for four SIMDs."""
    count, unit, most, local, lanes = {
        "gfx1100": (1536, 24, 16, 128 * 1024, 32),
        "gfx942": (512, 8, 8, 64 * 1024, 64),
    }[target]
    by_registers = count // (-(-max(registers, 1) // unit) * unit)
    groups = local // max(local_bytes, 1)
    by_local = groups * (group // lanes) / 4
    return min(by_registers, by_local, most) / most


def run(command, env):
    """Runs a compiler and returns what it says."""
    done = subprocess.run([str(part) for part in command], env=env, text=True, capture_output=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


class Compilers:
    def __init__(self):
        self.clang_root = fetched.debian("clang-19", CLANG)
        self.nvcc_root = fetched.wheels("ptxas-12.9", PTXAS)
        lib = self.clang_root / "usr/lib"
        self.env = fetched.with_libraries(lib / "llvm-19/lib", fetched.only(lib, "*-linux-gnu"))
        self.clang = lib / "llvm-19/bin/clang"
        self.builtins = lib / "clc"
        self.ptxas = fetched.only(self.nvcc_root, "**/ptxas")
        self.ptxas.chmod(0o755)

    def compile(self, text, triple, cpu, builtins, output):
        link = ["-Xclang", "-mlink-builtin-bitcode", "-Xclang", self.builtins / builtins]
        header = ["-Xclang", "-finclude-default-header"]
        run([self.clang, *OPTIONS.split(), *header, "-target", triple, cpu, "-nogpulib", *link, "-S",
             "-o", output, text], self.env)

    def nvidia(self, text, target):
        """Yields the figures of each kernel, as ptxas prints them."""
        ptx = text.with_suffix(f".{target}.ptx")
        triple = "nvptx64--nvidiacl"
        self.compile(text, triple, f"-march={target}", f"{triple}.bc", ptx)
        said = run([self.ptxas, "-v", f"-arch={target}", "-o", os.devnull, ptx], self.env)
        # Functions that kernels call have figures of their own, which come after the kernel's.
        for part in said.split("Compiling entry function '")[1:]:
            def number(pattern):
                return sum(int(n) for n in re.findall(pattern, part))

            kernel, registers = part.split("'")[0], number(r"Used (\d+) registers")
            group, added = shape_of(kernel)
            local = number(r"(\d+) bytes smem") + added
            yield {
                "kernel": kernel,
                "registers": registers,
                "spilled_bytes": number(r"(\d+) bytes spill stores"),
                "stack_bytes": number(r"(\d+) bytes cumulative stack size"),
                "local_bytes": local,
                "occupancy": warps_of_sm_90(registers, local, group),
            }

    def amd(self, text, target):
        """Yields the figures of each kernel, from the assembler's metadata."""
        assembly = text.with_suffix(f".{target}.s")
        triple = "amdgcn-amd-amdhsa"
        self.compile(text, triple, f"-mcpu={target}", "amdgcn--amdhsa.bc", assembly)
        metadata = assembly.read_text().split("amdhsa.kernels:")[1].split("amdhsa.target:")[0]
        for part in re.split(r"^  - ", metadata, flags=re.M)[1:]:
            def number(name):
                return int(re.search(rf"\.{name}:\s+(\d+)", part)[1])

            kernel = re.search(r"^    \.name:\s+(\w+)", part, re.M)[1]
            group, added = shape_of(kernel)
            local = number("group_segment_fixed_size") + added
            registers = number("vgpr_count")
            yield {
                "kernel": kernel,
                "registers": registers,
                "spilled_bytes": 4 * number("vgpr_spill_count"),
                "stack_bytes": number("private_segment_fixed_size"),
                "local_bytes": local,
                "occupancy": waves(target, registers, local, group),
            }


def figures():
    """Compiles all texts, and returns the figures of each kernel on each target."""
    compilers, found = Compilers(), {}
    with tempfile.TemporaryDirectory() as folder:
        env = {**os.environ, "POPULACE_KERNEL_TEXTS": folder}
        test = "texts_of_gpus_hold_the_kernels_that_they_run"
        command = ["cargo", "test", "-q", "-p", "populace-opencl", "--lib", test]
        subprocess.run(command, cwd=fetched.ROOT, env=env, check=True, stdout=sys.stderr)
        texts = sorted(Path(folder).glob("*.cl"))
        if not texts:
            sys.exit(f"the test {test} wrote no texts")
        for target in NVIDIA + AMD:
            read = compilers.nvidia if target in NVIDIA else compilers.amd
            for text in texts:
                for kernel in read(text, target):
                    kernel["occupancy"] = round(100 * kernel["occupancy"])
                    # A kernel that several texts hold is the same in all.
                    found[target, kernel["kernel"]] = {"target": target, **kernel}
    return found


def exceeded(kernel, budget):
    """Returns the names of the figures that are worse than the budget."""
    most = [name for name in FIELDS[2:6] if kernel[name] > int(budget[name])]
    least = ["occupancy"] if kernel["occupancy"] < int(budget["occupancy"]) else []
    return most + least


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--renew", action="store_true", help="write the budget from these figures")
    renew = parser.parse_args().renew
    found = figures()
    if renew:
        with BUDGET.open("w", newline="") as file:
            writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(found.values())
    with BUDGET.open() as file:
        budgets = {(row["target"], row["kernel"]): row for row in csv.DictReader(file)}
    failed = [f"{at[0]} {at[1]}: no longer a kernel; renew the budget" for at in budgets.keys() - found]
    print("".join(f"{name:>15}" if n > 1 else f"{name:<22}" for n, name in enumerate(FIELDS)))
    for at, kernel in found.items():
        print("".join(f"{v:>15}" if n > 1 else f"{v:<22}" for n, v in enumerate(kernel.values())))
        if at not in budgets:
            failed.append(f"{at[0]} {at[1]}: has no budget")
            continue
        for name in exceeded(kernel, budgets[at]):
            failed.append(f"{at[0]} {at[1]}: {name} {kernel[name]}, budget {budgets[at][name]}")
    if failed:
        sys.exit("\n".join(["over budget:", *failed]))


if __name__ == "__main__":
    main()
