// What carries requests and news between the page and a studio: here a WebSocket to the server that
// has sent the page. The playground has another one in this file's place (playground/wire.ts).

export const IN_PAGE = false;

export type Wire = { readonly open: boolean; send(text: string): void };

// `cut` is told when nothing comes any more; with a reason if there is no use in trying again.
export function connect(
  news: (data: string | ArrayBuffer) => void,
  cut: (why?: string) => void,
): Wire {
  const token = encodeURIComponent(location.hash.slice(1));
  const socket = new WebSocket(`ws://${location.host}/link?token=${token}`);
  socket.binaryType = 'arraybuffer';
  socket.onmessage = ({ data }) => news(data);
  socket.onclose = () => cut();
  return {
    get open() {
      return socket.readyState === WebSocket.OPEN;
    },
    send: (text) => socket.send(text),
  };
}
