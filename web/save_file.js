// Hands a file to the browser's downloads. A plain link could not carry the token.
export async function saveFile(name, blob) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(await blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
